#pragma once

#include "sgraph_slam/core/types/pose.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// An estimate to be compared with the truth where the map says that it doesn't know the heights of some storeys (rides in lifts): what is on these
/// is moved along the vertical to where the truth has it on average, so that all other errors count; poses of a ride itself are left out. With all
/// heights known it is the estimate.
Trajectory at_true_heights(const Trajectory& estimate, const Trajectory& truth, const GraphSnapshot& graph);

}  // namespace sgraph
