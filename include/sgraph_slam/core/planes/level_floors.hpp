#pragma once

#include <optional>
#include <set>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/graph/factors/aligned_walls.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"

namespace sgraph {

/// The storeys that planes are of; the stairwell is none.
std::set<int> storeys_of(const PlaneMap& planes);

/// The largest floor of a storey that at least three keyframes have seen.
std::optional<PlaneId> largest_floor(const Graph& graph, const PlaneMap& planes, int storey);

/// The second of two floors or ceilings is `rise` [m] above the first at a point (map frame), to a standard deviation [m]; its tilt is free.
AlignedWalls at_height(PlaneId a, PlaneId b, const Eigen::Vector3d& at, double rise, double sigma);

/// Whether the factor joins floors that a ride in a lift was measured between, and not walls, or floors that are drawn at one height.
bool are_floors_apart(const AlignedWalls& walls);

/// Floors of one building are level: joins the largest floor of each storey to the first storey's largest by `ParallelPlanes`, once both have been
/// seen from three keyframes. A floor that slopes is left alone, but not on a storey that a lift led to: on the way there nothing held the tilt.
/// Returns how many were joined.
int level_floors(Committer& committer, const PlaneMap& planes, const std::set<int>& by_lift);

}  // namespace sgraph
