#pragma once

#include <visualization_msgs/MarkerArray.h>

#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// The S-Graph for rviz, its three layers `layer_height` [m] apart so that they can be told from each other: keyframes and the way between them where
/// they are, planes as polygons above, rooms and corridors as nodes on top, with names and sizes and a line to each of their walls. Begins with a
/// marker that deletes what an earlier message drew.
visualization_msgs::MarkerArray graph_markers(const GraphSnapshot& snapshot, double layer_height);

}  // namespace sgraph
