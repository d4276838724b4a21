#pragma once

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/types/ids.hpp"

namespace sgraph {

/// Two planes at a right angle: neighbouring walls of a room, wall and floor.
///
///   e = (n_a . n_b) / sigma,  1 residual: cosine of the angle, to first order its distance from 90 degrees [rad]
///
/// Blocks: plane a, plane b. Degenerate for parallel planes. Source: design: Rooms and corridors, informative mechanism 2.
struct PerpendicularPlanes {
  PlaneId a;
  PlaneId b;
  double sigma = 0.0175;  ///< standard deviation of the angle [rad]

  static constexpr const char* type = "perpendicular_planes";
  static constexpr int residuals = 1;
  static constexpr int rank = 1;

  template <class Self, class Visitor>
  static void describe(Self& f, Visitor& v) {
    v.blocks("planes", f.a, f.b);
    v.sigma("sigma", f.sigma);
  }
};

CostPtr make_cost(const PerpendicularPlanes& factor);

}  // namespace sgraph
