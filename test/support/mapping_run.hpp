#pragma once

#include <vector>

#include "mapped_building.hpp"
#include "sgraph_slam/core/mapping/back_end.hpp"

namespace sgraph {

/// Four rooms on both sides of a corridor, 15 cm walls, open doors; and a walk through all of it, back to the start.
MappedBuilding office();
std::vector<Eigen::Vector2d> office_walk();

/// What the mapping made of a walk, against the truth.
struct Outcome {
  GraphSnapshotPtr snapshot;
  DecisionLog decisions;
  double ate = 0;           ///< of the graph, optimised at the end [m]
  double odometry_ate = 0;  ///< [m]
};

/// Feeds a walk to a back end and optimises at the end. With SGRAPH_SHOW in the environment it prints what came of it.
Outcome map_walk(const std::vector<SeenKeyframe>& walk, const MappingParams& params);

}  // namespace sgraph
