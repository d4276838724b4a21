#pragma once

#include <map>
#include <vector>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/graph/marginals_cache.hpp"
#include "sgraph_slam/core/graph/odometry_drift.hpp"
#include "sgraph_slam/core/loops/params.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// A way back to an old keyframe that one search has found.
struct LoopCandidate {
  KeyframeId from;  ///< the old keyframe
  KeyframeId to;    ///< the newest one at the time
  Pose T_from_to;
};

/// What loop closing is told of, and what it remembers.
struct LoopCloser {
  LoopParams params;
  Pose T_base_lidar;
  KeyframeId last_tried;
  KeyframeId last_searched = {};               ///< by appearance
  bool held = false;                           ///< the graph knew well enough where it was when that was asked last
  std::vector<LoopCandidate> candidates = {};  ///< by appearance, not believed yet
};

/// Hard loop closure of the newest keyframe with the nearest old one, when the graph is unsure about the way between (paper, Loop Closure). True when
/// a loop has been added. `keyframes`: all of the graph's, with their clouds.
bool close_loop(Committer& committer, LoopCloser& loops, const std::map<KeyframeId, SceneKeyframe>& keyframes, const OdometryDrift& drift,
                MarginalsCache& cache);

}  // namespace sgraph
