#pragma once

#include <map>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/graph/marginals_cache.hpp"
#include "sgraph_slam/core/graph/odometry_drift.hpp"
#include "sgraph_slam/core/loops/params.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// What loop closing is told of, and what it remembers.
struct LoopCloser {
  LoopParams params;
  Pose T_base_lidar;
  KeyframeId last_tried;
};

/// Hard loop closure of the newest keyframe with the nearest old one, when the graph is unsure about the way between (paper, Loop Closure). True when
/// a loop has been added. `keyframes`: all of the graph's, with their clouds.
bool close_loop(Committer& committer, LoopCloser& loops, const std::map<KeyframeId, SceneKeyframe>& keyframes, const OdometryDrift& drift,
                MarginalsCache& cache);

}  // namespace sgraph
