#pragma once

#include <array>
#include <optional>
#include <vector>

#include "sgraph_slam/core/places/params.hpp"
#include "sgraph_slam/core/places/place_view.hpp"

namespace sgraph {

/// Two walls facing each other along a free space. Its state in the graph is the position across and the width (paper, Topological Layer); the rest
/// is derived from where the walls have been seen.
struct CorridorShape {
  std::array<PlaneId, 2> walls;  ///< at the right and the left hand of its direction
  OrientedRectangle area;        ///< x along the corridor: size.x is its length, size.y its width
  std::array<bool, 2> closed{};  ///< whether a wall closes its low and high end
  double coverage = 0;           ///< share of the two sides where wall has been seen
};

/// Why a place is or is not a corridor; the first test that fails, in this order.
enum class CorridorVerdict {
  accepted,
  no_walls,   ///< no facing pair at a corridor's width
  uncovered,  ///< too little of a side is wall
  short_,     ///< common stretch under the limit, or hardly longer than wide
  long_,      ///< common stretch over the limit
  room,       ///< closed at both ends and not long: the rooms' matter
  cut,        ///< another wall runs along the inside
};

const char* to_string(CorridorVerdict value);

struct CorridorSearch {
  CorridorVerdict verdict = CorridorVerdict::no_walls;
  std::optional<CorridorShape> corridor;
};

/// Whether two corridors are stretches of one: parallel within params.parallel, side by side within params.coplanar, as wide, and overlapping.
bool same_corridor(const CorridorShape& a, const CorridorShape& b, const CorridorParams& params);

/// The corridor around a position where the robot has been, if the walls make one. Its direction is the one of the two possible whose heading is
/// within
/// (-45, 135] degrees of `reference_yaw` [rad].
CorridorSearch find_corridor(const std::vector<Wall>& walls, const Eigen::Vector2d& position, double reference_yaw, const CorridorParams& params);

/// Whether a corridor's two walls still make one around its centre, and its shape as the walls are now; `slack` as for rooms.
CorridorSearch judge_corridor(const std::vector<Wall>& walls, const CorridorShape& corridor, const CorridorParams& params, double slack);

}  // namespace sgraph
