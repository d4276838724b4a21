#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <vector>

#include "sgraph_slam/core/graph/graph.hpp"
#include "sgraph_slam/core/graph/recent_solver.hpp"
#include "sgraph_slam/core/loops/close_loop.hpp"
#include "sgraph_slam/core/mapping/params.hpp"
#include "sgraph_slam/core/places/topological_layer.hpp"
#include "sgraph_slam/core/planes/plane_layer.hpp"
#include "sgraph_slam/core/types/decision.hpp"
#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// The recording that is being mapped, where it goes on with a map made earlier: its keyframes get ids after the others, and its odometry is moved
/// into the frame of theirs, so that the map has one odometry that jumps where one session ends and another begins.
struct Session {
  std::int64_t first = 0;                    ///< id of its first keyframe
  Pose T_odom_own;                           ///< the map's odometry from the session's own
  Matrix6 covariance = Matrix6::Identity();  ///< of its first pose in the map, as of a keyframe's motion
};

/// A lift has carried the robot.
struct KeyframeRide {
  KeyframeId first;                          ///< the first keyframe after it
  Rise rise = unknown_rise;                  ///< from floor to floor
  bool placed = false;                       ///< whether the floors have been set apart by that
  std::optional<int> storey = std::nullopt;  ///< where it ended, when that was seen before
  bool settled = false;                      ///< whether that is decided
};

/// All that the back end knows: the graph, and beside it what each layer keeps. Data only; a copy is a state to come back to.
struct MapState {
  /// `clouds`: where the keyframes' clouds go; null: they stay in memory.
  MapState(const MappingParams& p, const Pose& T_base_lidar, std::shared_ptr<KeyframeClouds> clouds_)
      : params(p),
        clouds(std::move(clouds_)),
        planes({p.factors, p.association, p.semantics, p.merging}, T_base_lidar),
        layer({p.topology, p.places, p.free_space, p.merging}),
        loops{p.loops, T_base_lidar, {}} {}

  MappingParams params;
  std::shared_ptr<KeyframeClouds> clouds;
  Graph graph;
  RecentSolver recent;
  std::map<KeyframeId, SceneKeyframe> keyframes;  ///< T_map_base as of the last snapshot: the graph has the estimates
  PlaneLayer planes;
  TopologicalLayer layer;
  LoopCloser loops;
  std::vector<SceneOpening> openings;
  std::size_t storeys = 0;         ///< how many have been found
  std::vector<int> storey_groups;  ///< of each: heights are known against each other within a group; the first's is 0
  std::vector<KeyframeRide> rides;
  std::map<PlaneId, Eigen::Matrix3d> plane_covariances;  ///< as of the last optimisation on demand
  DecisionLog log;
  Pose T_map_odom;  ///< of the session that is going on
  Session session;

  std::set<PlanePair> pending_merges;  ///< planes that a place showed to be one, since the last global solve
  bool merging_due = false;            ///< the whole graph was solved with the last keyframe
  std::set<KeyframeId> retired_with_clouds;
  std::vector<KeyframeId> clouds_let_go;  ///< keyframes whose clouds nobody needs any more, since the map was last shown
  KeyframeId solved;                      ///< the newest one when the whole graph was last solved
  int since_global = 0;                   ///< keyframes since the last global solve
  int since_places = 0;                   ///< keyframes since places were last found
  bool optimized = false;                 ///< since the last keyframe
};

}  // namespace sgraph
