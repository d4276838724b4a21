#pragma once

#include <string>

#include "sgraph_slam/core/io/params.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// Writes what is known of a map into a folder, which is made when it isn't there: graph.json, keyframes.tum, map.pcd, map.pgm and map.yaml,
/// floor_plan.png, .svg and .dxf, decisions.csv. `path`: base poses in the map, for the drawing. Throws std::runtime_error with the file and the
/// reason.
void write_map(const std::string& folder, const GraphSnapshot& snapshot, const Trajectory& path, const Pose& T_base_lidar,
               const OutputParams& params);

/// A row a decision: newest keyframe, "accepted" or "refused", what, why.
std::string decisions_csv(const DecisionLog& decisions);

/// A trajectory as the text of a TUM file.
std::string tum_text(const Trajectory& trajectory);

}  // namespace sgraph
