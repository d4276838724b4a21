#pragma once

#include <array>
#include <optional>
#include <vector>

#include "sgraph_slam/core/places/find_places.hpp"

namespace sgraph {

/// The four walls of a room, counter-clockwise, and the direction in which the outline runs along each.
struct FourWalls {
  std::array<PlaneId, 4> faces;
  std::array<Eigen::Vector2d, 4> directions;
  std::array<double, 4> lengths{};  ///< of the outline along each [m]
};

/// The walls of an outline that has four: each side of the rectangle around it lies on a face for at least half its length, and next to nothing of
/// the rectangle is missing. A cabinet or a shaft in a corner, a column in the middle, a corner that is cut take none of them away. What an alcove
/// adds lies beyond a wall, which then bounds no more than the alcove.
std::optional<FourWalls> four_walls(const PlaceOutline& outline);

/// The room between four walls; a corridor when it is long and narrow.
FoundPlace room_or_corridor(const PlaceOutline& outline, const FourWalls& four, const std::vector<Wall>& walls, double reference_yaw,
                            const PlaceParams& params);

/// The rectangle around a polygon along its longest side.
OrientedRectangle rectangle_around(const Polygon2d& polygon);

}  // namespace sgraph
