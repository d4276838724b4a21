#pragma once

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/graph/variables.hpp"

namespace sgraph {

/// Which wall of a room: at the low or high end of its x or y axis. In the order of SceneRoom::planes.
enum class RoomSide { x_low, x_high, y_low, y_high };

const char* to_string(RoomSide value);
inline int axis_of(RoomSide side) { return side == RoomSide::x_low || side == RoomSide::x_high ? 0 : 1; }

/// A wall of a room.
///
///   e = ( n . c + d - w_axis / 2 ) / sigma,  1 residual [m]: how much further than half the width the centre is from the wall
///   c = centre of the room in the map, from position, yaw and z; w_axis: its width along the side's axis
///
/// Blocks: room, plane. For a wall exactly along the room's axes it is the paper's `(rho - w/2) - s` at a low side (n along the axis, s = -d) and its
/// negative at a high side (s = +d). Measured at the room's centre, not by the distance to the map's origin, it also holds for a wall a degree off
/// the axes far from the origin, and doesn't change when the whole world moves. Normals point into the room, so the side of the wall is in the sign.
/// The four factors of a room determine its four states and tell planes and poses nothing; see the design's rank argument.
/// Degenerate for a wall at right angles to the side's axis. Source: paper, Topological Layer; design: Rooms and corridors.
struct RoomPlane {
  RoomId room;
  PlaneId plane;
  RoomSide side = RoomSide::x_low;
  double sigma = 0.02;  ///< standard deviation [m]

  static constexpr const char* type = "room_plane";
  static constexpr int residuals = 1;
  static constexpr int rank = 1;
  [[nodiscard]] RoomId constants_of() const { return room; }

  template <class Self, class Visitor>
  static void describe(Self& f, Visitor& v) {
    v.block("room", f.room);
    v.block("plane", f.plane);
    v.choice("side", f.side, {RoomSide::x_low, RoomSide::x_high, RoomSide::y_low, RoomSide::y_high});
    v.sigma("sigma", f.sigma);
  }
};

/// `room`: for its constants (yaw, z).
CostPtr make_cost(const RoomPlane& factor, const Room& room);

}  // namespace sgraph
