#pragma once

#include <vector>

#include "extraction.hpp"

namespace sgraph {

/// Joins surfaces that are parts of one: facing the same side, at most merge_gap apart, and each lying on the common plane within the noise.
std::vector<FlatSurface> merge_coplanar(const PointSet& points, std::vector<FlatSurface> surfaces, const Limits& limits);

/// Gives every point to the nearest surface (by its limit there) that covers it, fits all surfaces anew without the points that lie in two that meet
/// at an angle, and drops those that have become too small. `labels` gets each point's surface, or -1.
std::vector<FlatSurface> reassign(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, std::vector<FlatSurface> surfaces,
                                  const Limits& limits, std::vector<int>& labels);

}  // namespace sgraph
