#pragma once

#include <map>
#include <set>

#include "sgraph_slam/core/graph/graph.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// A map made earlier, as the back end needs it to go on with it. Places are found again from the walls.
struct KeptMap {
  Graph graph;                                    ///< keyframes, planes and the factors between them
  std::set<KeyframeId> sessions;                  ///< the first keyframe of each session
  std::map<KeyframeId, SceneKeyframe> keyframes;  ///< odometry in one frame for all sessions
  std::map<PlaneId, PlaneRecord> planes;          ///< class, observations, retired, last_covariance; the rest is made again
  std::map<PlaneId, PlaneRecord> merged;          ///< the same of planes that were merged into others, as they were
};

}  // namespace sgraph
