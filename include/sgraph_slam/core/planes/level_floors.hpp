#pragma once

#include <vector>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"

namespace sgraph {

/// Floors of one building are level: joins the largest floor of each of these storeys to the first storey's largest by `ParallelPlanes`, once both
/// have been seen from three keyframes. For storeys that a lift led to, on the way to which nothing held the tilt. Returns how many were joined.
int level_floors(Committer& committer, const PlaneMap& planes, const std::vector<int>& storeys);

}  // namespace sgraph
