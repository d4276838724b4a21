#pragma once

#include <set>
#include <vector>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/planes/plane_layer.hpp"
#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/segments.hpp"

namespace sgraph {

/// What one keyframe's planes brought.
struct AssociationResult {
  std::vector<PlaneId> planes;  ///< of each segment, in their order: the plane that it was taken for; not valid when it was ignored
  std::set<PlaneId> seen;       ///< the planes matched or made
  int matched = 0;
  int created = 0;
  int ignored = 0;        ///< broken, too small to make a plane, or of an unsure side and unknown
  bool returned = false;  ///< a plane was seen again after a long way
};

/// Associates the segments of the newest keyframe, makes planes of what is new, adds the observations (paper, Metric-Semantic Layer). Segments whose
/// numbers make no sense are ignored. Nothing is seen when the graph refuses the edit; that is logged.
AssociationResult add_observations(Committer& committer, PlaneLayer& planes, const Keyframe& newest, const PlaneSegments& segments);

}  // namespace sgraph
