#include "sgraph_slam/core/graph/factors/pose_plane.hpp"

#include "plane_observation.hpp"

namespace sgraph {

CostPtr make_cost(const PosePlane& factor) { return make_cost(PlaneObservation::of(factor)); }

}  // namespace sgraph
