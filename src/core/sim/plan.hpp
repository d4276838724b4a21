#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/sim/world.hpp"

namespace sgraph::sim {

/// Walls of a polyline, with the bodies extended at its corners so that they close. A closed polyline repeats its first point at the end.
std::vector<Wall> walls_along(const std::vector<Eigen::Vector2d>& path, const Wall& like);

/// Cuts an opening of the given width with its middle at `at` into the wall that passes there. Returns what is wrong, empty when nothing is:
/// no wall there, two walls, beyond the wall's end, overlapping another opening, higher than the wall.
std::string cut_opening(std::vector<Wall>& walls, const Eigen::Vector2d& at, double width, Opening opening);

/// The rectangle between the nearest wall faces seen from `at` along +-x and +-y of a frame turned by `yaw` (doors count as wall). Returns what is
/// wrong in `error` when a side has no wall or one that isn't at a right angle to it.
std::optional<Place> place_between_walls(const Storey& storey, const Eigen::Vector2d& at, double yaw, std::string& error);

/// Closed rectangle around all walls with their thickness, counter-clockwise.
std::vector<Eigen::Vector2d> bounding_outline(const std::vector<Wall>& walls);

/// Outline of a block on the floor, counter-clockwise; of a round one a 16-gon.
std::vector<Eigen::Vector2d> footprint(const Block& block);

/// The full-height pieces of a wall's body and the heads and sills over its openings: intervals along the wall and in height above the wall's
/// bottom. With panes counted as body when `panes` is set.
struct WallPiece {
  double begin = 0;
  double end = 0;
  double bottom = 0;
  double top = 0;
};
std::vector<WallPiece> pieces_of(const Wall& wall, bool panes);

}  // namespace sgraph::sim
