#pragma once

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/types/ids.hpp"

namespace sgraph {

/// The width of a room as one keyframe measured it (independent of the map's estimate), once per keyframe.
///
///   e = ( w_axis - measured ) / sigma,  1 residual [m]
///
/// Block: room. `keyframe` only says who measured; its pose is not involved. Source: design: Rooms and corridors, informative mechanism 3.
struct RoomWidth {
  RoomId room;
  KeyframeId keyframe;
  int axis = 0;         ///< 0: along the room's x, 1: along its y
  double measured = 0;  ///< [m]
  double sigma = 0.02;  ///< standard deviation [m]

  static constexpr const char* type = "room_width";
  static constexpr int residuals = 1;
  static constexpr int rank = 1;

  template <class Self, class Visitor>
  static void describe(Self& f, Visitor& v) {
    v.block("room", f.room);
    v.field("keyframe", f.keyframe);
    v.index("axis", f.axis, 2);
    v.field("measured", f.measured);
    v.sigma("sigma", f.sigma);
  }
};

CostPtr make_cost(const RoomWidth& factor);

}  // namespace sgraph
