#pragma once

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/types/ids.hpp"

namespace sgraph {

/// The width of a corridor as one keyframe measured it (independent of the map's estimate), once per keyframe.
///
///   e = ( w - measured ) / sigma,  1 residual [m]
///
/// Block: corridor. `keyframe` only says who measured; its pose is not involved. Source: design: Rooms and corridors, informative mechanism 3.
struct CorridorWidth {
  CorridorId corridor;
  KeyframeId keyframe;
  double measured = 0;  ///< [m]
  double sigma = 0.02;  ///< standard deviation [m]

  static constexpr const char* type = "corridor_width";
  static constexpr int residuals = 1;
  static constexpr int rank = 1;

  template <class Self, class Visitor>
  static void describe(Self& f, Visitor& v) {
    v.block("corridor", f.corridor);
    v.field("keyframe", f.keyframe);
    v.field("measured", f.measured);
    v.sigma("sigma", f.sigma);
  }
};

CostPtr make_cost(const CorridorWidth& factor);

}  // namespace sgraph
