#pragma once

#include <string>

#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// The snapshot as the text of graph.json: everything but the keyframes' clouds, numbers exact. Beside the fields that other programs rely on, a
/// keyframe has `nanoseconds` (its exact stamp), `odom_pose` and `scans`.
std::string graph_json(const GraphSnapshot& snapshot);

/// The snapshot back from that text; keyframes come without clouds. Throws std::runtime_error: no JSON, another format, or what is missing.
GraphSnapshot parse_graph_json(const std::string& text);

}  // namespace sgraph
