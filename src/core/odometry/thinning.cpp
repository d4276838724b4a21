#include "sgraph_slam/core/odometry/thinning.hpp"

#include "sgraph_slam/core/util/scattered_order.hpp"
#include "sgraph_slam/core/util/voxel_set.hpp"

namespace sgraph {

std::vector<Point> thinned(const std::vector<Point>& points, double leaf) {
  if (leaf <= 0) return points;
  VoxelSet seen(leaf, points.size());
  return kept_scattered(points, [&seen](const Point& p) { return seen.insert(p.x, p.y, p.z); });
}

}  // namespace sgraph
