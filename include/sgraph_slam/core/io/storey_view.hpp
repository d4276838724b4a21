#pragma once

#include <set>

#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// The storeys that keyframes stand on, without the stairwell.
std::set<int> storeys_of(const GraphSnapshot& snapshot);

/// What of a map is of one storey: its keyframes, planes, places and doors. Factors and decisions are left out.
GraphSnapshot of_storey(const GraphSnapshot& snapshot, int storey);

/// The map with each storey raised by `gap` [m] above the one below, for drawings; who is on stairs is raised in proportion to his height between
/// the floors, so that the path stays in one piece.
GraphSnapshot exploded(GraphSnapshot snapshot, double gap);

/// The poses of a path (by their stamps) that belong to the keyframes of a snapshot.
Trajectory path_of(const GraphSnapshot& snapshot, const Trajectory& path);

}  // namespace sgraph
