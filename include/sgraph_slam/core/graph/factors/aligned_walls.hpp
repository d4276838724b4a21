#pragma once

#include <Eigen/Core>

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/types/ids.hpp"

namespace sgraph {

/// Walls of two storeys, one straight above the other.
///
///   f(p) = n_a . p + d_a - n_b . (p + rise z) - d_b  at p = from and p = to
///   e = ( (f(from) + f(to)) / (sqrt 2 shift_sigma), (f(from) - f(to)) / (sqrt 2 sigma) ),  2 residuals
///
/// from, to: where the stretch that both have begins and ends, at the height of wall a, map frame, constants; rise: how far above it wall b is, so
/// that a wall that leans is compared with the other at their own heights. The first residual holds where the walls stand, the second their
/// direction, as well as their length allows. Two floors that are drawn at one height are joined by the first alone. Blocks: plane a, plane b.
/// Source: design: Storeys.
struct AlignedWalls {
  PlaneId a;
  PlaneId b;
  Eigen::Vector3d from = Eigen::Vector3d::Zero();  ///< map frame [m]
  Eigen::Vector3d to = Eigen::Vector3d::Zero();    ///< map frame [m]
  double rise = 0;                                 ///< [m]
  double sigma = 0.02;                             ///< standard deviation at either end [m]
  double shift_sigma = 0.02;                       ///< the same for what both ends share [m]

  static constexpr const char* type = "aligned_walls";
  static constexpr int residuals = 2;
  static constexpr int rank = 2;

  template <class Self, class Visitor>
  static void describe(Self& f, Visitor& v) {
    v.blocks("planes", f.a, f.b);
    v.sigma("sigma", f.sigma);
    v.sigma("shift_sigma", f.shift_sigma);
    v.field("from", f.from);
    v.field("to", f.to);
    v.field("rise", f.rise);
  }
};

CostPtr make_cost(const AlignedWalls& factor);

}  // namespace sgraph
