#pragma once

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/planes/plane_layer.hpp"

namespace sgraph {

/// Drops small planes that few keyframes have seen, long ago, and ghosts: planes of any size with few views beside one that is known much better
/// (these at once if `all`), or that the robot has walked through. Returns how many.
int drop_passing_planes(Committer& committer, PlaneLayer& planes, bool all);

}  // namespace sgraph
