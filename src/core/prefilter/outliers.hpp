#pragma once

#include <vector>

#include "sgraph_slam/core/prefilter/params.hpp"
#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// Drops the outliers that `params.outliers` ("none", "radius" or "statistical") names from the points, which keep their order. Returns how many.
int remove_outliers(std::vector<Point>& points, const PrefilterParams& params);

}  // namespace sgraph
