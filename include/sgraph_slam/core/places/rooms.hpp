#pragma once

#include <array>
#include <optional>
#include <vector>

#include "sgraph_slam/core/places/params.hpp"
#include "sgraph_slam/core/places/place_view.hpp"

namespace sgraph {

/// Four walls around a free space. Its state in the graph is centre and widths in its own axes (paper, Topological Layer).
struct RoomShape {
  std::array<PlaneId, 4> walls;  ///< at -x, +x, -y, +y of the room
  OrientedRectangle area;        ///< centre, widths, yaw
  double coverage = 0;           ///< share of the outline where wall, or furniture before it, has been seen
  double wall_coverage = 0;      ///< share of the outline where the walls themselves have been seen
};

/// How well four walls make a room: how much of its outline has been seen, how much of it as wall, and, since what stands before the walls makes
/// smaller rectangles but nothing makes larger ones that stand the tests, how large it is. For comparing rooms around one position.
double room_score(const RoomShape& room);

/// Why a place is or is not a room; the first test that fails, in this order.
enum class RoomVerdict {
  accepted,
  no_walls,   ///< not walls on all four sides
  narrow,     ///< a width under its limit
  wide,       ///< a width over its limit
  corridor,   ///< long and narrow: the corridors' matter
  uncovered,  ///< too little of a side is wall
  cut,        ///< another wall runs through the inside
};

const char* to_string(RoomVerdict value);

struct RoomSearch {
  RoomVerdict verdict = RoomVerdict::no_walls;  ///< of the best candidate: the one that came furthest through the tests
  std::optional<RoomShape> room;
};

/// The room around a position (where the robot has been: free space inside is thereby shown), if the walls make one: among all that stand the tests,
/// the one with the best score. `reference_yaw` [rad] tells which of the four headings is the room's x axis: the nearest.
RoomSearch find_room(const std::vector<Wall>& walls, const Eigen::Vector2d& position, double reference_yaw, const RoomParams& params);

/// Whether a room's four walls still make a room, and its shape as the walls are now. `slack` (0..1) eases the limits on coverage, so that a room is
/// not made and withdrawn in turns.
RoomSearch judge_room(const std::vector<Wall>& walls, const RoomShape& room, const RoomParams& params, double slack);

}  // namespace sgraph
