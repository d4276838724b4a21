#pragma once

#include <string>
#include <vector>

#include "sgraph_slam/core/sim/world.hpp"

namespace sgraph::sim {

/// The places of a storey: the pieces of floor that its walls enclose, doors and panes counted as wall, openings that `join` as open. Bounded by the
/// walls' faces at half height; what is lower than 1.8 m, columns and furniture bound nothing. Named and classed by the seeds that lie within, in the
/// order of the seeds; then those without a seed, as rooms "place 1", ... from the lower left. Throws WorldError for a seed of the key `places` that
/// no walls enclose.
std::vector<Region> regions_of(const Storey& storey, const std::string& file);

/// Index of the region that holds a point of the floor at least `margin` [m] from its edge; -1 when none does.
int region_at(const std::vector<Region>& regions, const Eigen::Vector2d& at, double margin = 0);

/// A passage between two places.
struct Doorway {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< its middle, on the wall's centre line
  double yaw = 0;                                      ///< of the wall [rad]
  double width = 0;                                    ///< [m]
  double height = 0;                                   ///< from the floor to its head [m]
  int from = -1;                                       ///< region on the left of the wall; -1: outdoors
  int to = -1;                                         ///< and on the right
  bool closed = false;
};

/// The openings down to the floor that lead from one region to another or outdoors, in the order of the walls.
std::vector<Doorway> doorways_of(const Storey& storey);

}  // namespace sgraph::sim
