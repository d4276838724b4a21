#pragma once

#include <vector>

#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// One point in each voxel of edge `leaf` [m], in the order in which they came; all when it is 0. Which one doesn't depend on the sweep (see
/// `visit_scattered`).
std::vector<Point> thinned(const std::vector<Point>& points, double leaf);

}  // namespace sgraph
