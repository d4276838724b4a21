#pragma once

#include <optional>
#include <vector>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"

namespace sgraph {

/// How one storey lies over another, by the walls of both.
struct StoreyFit {
  int lower = 0;  ///< the storey below
  /// Of the upper storey against the lower: x, y [m], turn about the map's z through `middle` [rad].
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  std::vector<AlignedWalls> walls;  ///< that agree with it
  double false_alarms = 0;          ///< expected number of shifts that so many walls agree with by chance
};

/// Walls stand on walls: looks for the shift under which walls of storey `upper` stand above walls of storey `lower` (facades, shafts, often all of
/// them). Nothing when as many could agree by chance, or all run in one direction. Walls that were seen from fewer than three keyframes don't count.
std::optional<StoreyFit> fit_storeys(const PlaneMap& planes, int lower, int upper);

/// Joins the walls of each storey to those of the earlier one with which most of them agree (`AlignedWalls`), in place of those joined before. Where
/// the heights of the two against each other are unknown (`height_groups`: of each storey; known within a group), the floor of the upper one is drawn
/// beside the other's until they are. Returns how many factors were added or removed.
int align_storeys(Committer& committer, const PlaneMap& planes, const std::vector<int>& height_groups);

}  // namespace sgraph
