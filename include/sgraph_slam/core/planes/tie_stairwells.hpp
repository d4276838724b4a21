#pragma once

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"

namespace sgraph {

/// A floor or ceiling that is seen from the stairs and from a storey is a plane of each, since planes are a storey's or the stairwell's. It is one
/// surface: joins those of the stairwell to those of the storeys that face the same way, lie at the same height and overlap, both seen from three
/// keyframes, in tilt (`ParallelPlanes`) and height (`AlignedWalls` at a point). Returns how many were joined.
int tie_stairwells(Committer& committer, const PlaneMap& planes);

}  // namespace sgraph
