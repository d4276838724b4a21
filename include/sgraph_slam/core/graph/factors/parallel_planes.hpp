#pragma once

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/types/ids.hpp"

namespace sgraph {

/// Two planes with the same or opposed direction: facing walls of a room or corridor, the two faces of a wall.
///
///   e = (n_a x n_b) / sigma,  3 residuals (rank 2): sine of the angle [rad]
///
/// Blocks: plane a, plane b. Smooth at zero, where the angle itself is not. Degenerate at 90 degrees, so it needs a robust loss, with which an
/// oblique wall can refuse. Source: design: Rooms and corridors, informative mechanism 2.
struct ParallelPlanes {
  PlaneId a;
  PlaneId b;
  double sigma = 0.0175;  ///< standard deviation of the angle [rad]

  static constexpr const char* type = "parallel_planes";
  static constexpr int residuals = 3;
  static constexpr int rank = 2;

  template <class Self, class Visitor>
  static void describe(Self& f, Visitor& v) {
    v.blocks("planes", f.a, f.b);
    v.sigma("sigma", f.sigma);
  }
};

CostPtr make_cost(const ParallelPlanes& factor);

}  // namespace sgraph
