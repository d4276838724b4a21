#pragma once

#include <map>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/graph/marginals_cache.hpp"
#include "sgraph_slam/core/graph/odometry_drift.hpp"
#include "sgraph_slam/core/loops/close_loop.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// Loop closure where the graph has drifted further than its planes and scans can bridge: the walls and the free space of the last metres are
/// searched for in all that was seen long before, at every position and heading (PlaceSearch). A search is believed when one place alone agrees with
/// all that was seen, when the graph allows the motion, and when other searches on the way have found the same motion (pairwise consistency;
/// Mangelson et al., ICRA 2018): all of them then enter the graph. Every place that agrees with what was seen and is accepted or refused is a
/// decision of the log. True when loops have been added.
bool close_loop_by_appearance(Committer& committer, LoopCloser& loops, const std::map<KeyframeId, SceneKeyframe>& keyframes, const PlaneMap& planes,
                              const OdometryDrift& drift, MarginalsCache& cache);

}  // namespace sgraph
