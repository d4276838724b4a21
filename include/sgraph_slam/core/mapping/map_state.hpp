#pragma once

#include <map>
#include <set>
#include <vector>

#include "sgraph_slam/core/graph/graph.hpp"
#include "sgraph_slam/core/graph/recent_solver.hpp"
#include "sgraph_slam/core/mapping/params.hpp"
#include "sgraph_slam/core/mapping/submap.hpp"
#include "sgraph_slam/core/places/topological_layer.hpp"
#include "sgraph_slam/core/planes/dominant_frame.hpp"
#include "sgraph_slam/core/planes/odometry_drift.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"
#include "sgraph_slam/core/planes/plane_uncertainty.hpp"
#include "sgraph_slam/core/types/decision.hpp"
#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// All that the back end knows; the functions of its steps work on it. Copied by nobody.
struct MapState {
  MapState(const MappingParams& p, const Pose& extrinsic)
      : params(p), T_base_lidar(extrinsic), planes(p.semantics), submap(p.submap, extrinsic), layer({p.topology, p.rooms, p.corridors, p.merging}) {}

  MappingParams params;
  Pose T_base_lidar;
  Graph graph;
  RecentSolver recent;
  PlaneMap planes;
  Submap submap;
  OdometryDrift drift;
  MarginalsCache marginals;
  std::map<KeyframeId, Keyframe> keyframes;
  DominantFrame frame;
  TopologicalLayer layer;
  std::vector<SceneOpening> openings;
  std::map<PlanePair, KeyframeId> tested_merges;         ///< beyond their gate, and when that was found
  std::set<PlanePair> refused_merges;                    ///< merged once and undone
  std::map<PlaneId, Eigen::Matrix3d> plane_covariances;  ///< as of the last optimisation on demand
  KeyframeId last_loop_tried;
  DecisionLog log;
  Pose T_map_odom;

  [[nodiscard]] KeyframeId newest() const { return keyframes.empty() ? KeyframeId{} : keyframes.rbegin()->first; }
};

/// Applies an edit, or logs why the graph refused it.
Applied commit(MapState& state, const Transaction& transaction);

void add_factor(Transaction& edit, const FactorData& data, const RobustLoss& loss = {});

/// What one keyframe's planes brought.
struct AssociationResult {
  std::set<PlaneId> seen;  ///< planes matched or made
  int matched = 0;
  int created = 0;
  int ignored = 0;        ///< broken, too small to make a plane, or of an unsure side and unknown
  bool returned = false;  ///< a plane was seen again after a long way
};

/// Adds the keyframe and its motion since the last one. False when it isn't newer than the last, or not finite; that is logged.
bool add_keyframe(MapState& state, const Keyframe& keyframe);

/// Associates the segments of the newest keyframe, makes planes of what is new, adds the observations (paper, Metric-Semantic Layer).
AssociationResult add_observations(MapState& state, const PlaneSegments& segments);

/// The keyframes' positions on the ground, in order.
std::vector<Eigen::Vector2d> path_of(const MapState& state);

/// Drops small planes that few keyframes have seen, long ago, and ghosts: planes of any size with few views beside one that is known much better
/// (these at once if `all`), or that the robot has walked through. Returns how many.
int drop_passing_planes(MapState& state, bool all);

/// Merges planes that are one surface by their marginals, more readily those that a place shows to be one; solves; undoes what doesn't fit.
/// Pairs found apart lately are not tried again unless `all`. Returns how many were merged and kept.
int merge_duplicates(MapState& state, const std::set<PlanePair>& shown_by_places, bool all);

/// Hard loop closure of the newest keyframe with the nearest old one, when the graph is unsure about the way between (paper, Loop Closure). True when
/// a loop has been added.
bool close_loop(MapState& state);

/// Widths that the newest keyframe saw of the rooms and corridors whose facing walls it saw both.
void add_widths(MapState& state, const PlaneSegments& segments);

/// The two faces of walls: as far apart as those of the building's other walls, and parallel.
void add_wall_faces(MapState& state);

/// Brings the graph's rooms and corridors in line with the layer and their constants with the walls.
void synchronise(MapState& state);

/// The whole state as readers see it; `with_factors`: the factors serialised, the views of the planes and the decisions too, which takes time.
GraphSnapshotPtr make_snapshot(const MapState& state, std::int64_t version, const SolveSummary& solve, bool with_factors);

}  // namespace sgraph
