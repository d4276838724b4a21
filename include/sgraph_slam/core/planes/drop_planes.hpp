#pragma once

#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/planes/plane_layer.hpp"

namespace sgraph {

/// The keyframes' positions on the ground, in order, map frame.
std::vector<Eigen::Vector2d> path_of(const Graph& graph);

/// Drops small planes that few keyframes have seen, long ago, and ghosts: planes of any size with few views beside one that is known much better
/// (these at once if `all`), or that the robot has walked through. Returns how many.
int drop_passing_planes(Committer& committer, PlaneLayer& planes, bool all);

}  // namespace sgraph
