#pragma once

#include <map>
#include <vector>

#include "sgraph_slam/core/graph/graph.hpp"
#include "sgraph_slam/core/graph/recent_solver.hpp"
#include "sgraph_slam/core/loops/close_loop.hpp"
#include "sgraph_slam/core/mapping/params.hpp"
#include "sgraph_slam/core/mapping/submap.hpp"
#include "sgraph_slam/core/places/topological_layer.hpp"
#include "sgraph_slam/core/planes/plane_layer.hpp"
#include "sgraph_slam/core/types/decision.hpp"
#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// All that the back end knows: the graph, and beside it what each layer keeps. Data only.
struct MapState {
  MapState(const MappingParams& p, const Pose& T_base_lidar)
      : params(p),
        planes({p.factors, p.association, p.semantics, p.merging}, T_base_lidar),
        submap(p.submap, T_base_lidar),
        layer({p.topology, p.rooms, p.corridors, p.merging}),
        loops{p.loops, T_base_lidar, {}} {}

  MappingParams params;
  Graph graph;
  RecentSolver recent;
  std::map<KeyframeId, Keyframe> keyframes;
  PlaneLayer planes;
  Submap submap;
  TopologicalLayer layer;
  LoopCloser loops;
  std::vector<SceneOpening> openings;
  std::map<PlaneId, Eigen::Matrix3d> plane_covariances;  ///< as of the last optimisation on demand
  DecisionLog log;
  Pose T_map_odom;
};

}  // namespace sgraph
