#pragma once

#include <vector>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"

namespace sgraph {

/// Walls stand on walls (facades, shafts, often all of them): looks for the shift and turn under which most walls of a storey stand above walls of an
/// earlier one. Nothing is joined when as many could agree by chance, or all run in one direction; walls seen from fewer than three keyframes don't
/// count.
///
/// Joins the walls of each storey to those of the earlier one with which most of them agree (`AlignedWalls`), in place of those joined before. Where
/// the heights of the two against each other are unknown (`height_groups`: of each storey; known within a group), the floor of the upper one is drawn
/// beside the other's until they are. Returns how many factors were added or removed.
int align_storeys(Committer& committer, const PlaneMap& planes, const std::vector<int>& height_groups);

}  // namespace sgraph
