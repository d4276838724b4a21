#include "sgraph_slam/core/io/map_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "sgraph_slam/core/math/outline_area.hpp"

namespace sgraph {
namespace {

bool finite(const Point& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

// 21 bits an axis: told apart up to a million leaves from the origin.
std::uint64_t voxel_of(const Eigen::Vector3d& p, double leaf) {
  const auto axis = [leaf](double value) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(value / leaf)) + (1 << 20)) & ((1U << 21) - 1);
  };
  return axis(p.x()) << 42 | axis(p.y()) << 21 | axis(p.z());
}

}  // namespace

Cloud map_cloud(const GraphSnapshot& snapshot, const Pose& T_base_lidar, double leaf) {
  Cloud map;
  map.frame = snapshot.frame;
  std::unordered_set<std::uint64_t> taken;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    if (!keyframe.cloud) continue;
    const Pose T_map_lidar = keyframe.T_map_base * T_base_lidar;
    map.stamp = keyframe.stamp;
    const Eigen::Matrix3d rotation = T_map_lidar.matrix();
    for (const Point& point : keyframe.cloud->points) {
      if (!finite(point)) continue;
      const Eigen::Vector3d p = rotation * point.position().cast<double>() + T_map_lidar.translation;
      if (leaf > 0 && !taken.insert(voxel_of(p, leaf)).second) continue;
      Point moved = point;
      moved.x = static_cast<float>(p.x());
      moved.y = static_cast<float>(p.y());
      moved.z = static_cast<float>(p.z());
      moved.time = 0;
      map.points.push_back(moved);
    }
  }
  return map;
}

std::string pcd_bytes(const Cloud& cloud) {
  const std::string count = std::to_string(cloud.size());
  std::string bytes =
      "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH " + count +
      "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA binary\n";
  bytes.reserve(bytes.size() + 16 * cloud.size());
  for (const Point& point : cloud.points) {
    const float values[] = {point.x, point.y, point.z, point.intensity};
    bytes.append(reinterpret_cast<const char*>(values), sizeof values);
  }
  return bytes;
}

std::optional<Plane> floor_below(const GraphSnapshot& snapshot, const SceneKeyframe& keyframe, const Pose& T_base_lidar) {
  const Pose T_map_lidar = keyframe.T_map_base * T_base_lidar;
  const ScenePlane* floor = nullptr;
  for (const auto& [id, plane] : snapshot.planes) {
    const double height = plane.plane.distance(T_map_lidar.translation);
    const bool below = plane.plane_class == PlaneClass::horizontal && plane.plane.normal.z() > 0 && height > 0.05;
    if (!below || plane.keyframes.count(keyframe.id) == 0) continue;
    if (floor == nullptr || outline_area(plane.extent) > outline_area(floor->extent)) floor = &plane;
  }
  if (floor != nullptr) return floor->plane;
  if (!keyframe.cloud) return std::nullopt;
  std::vector<double> heights;
  for (const Point& point : keyframe.cloud->points) {
    if (finite(point)) heights.push_back((T_map_lidar * point.position().cast<double>()).z());
  }
  if (heights.empty()) return std::nullopt;
  // A few points lie below any floor: reflections, and what is seen through a stairwell.
  const auto low = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 50);
  std::nth_element(heights.begin(), low, heights.end());
  return Plane{Eigen::Vector3d::UnitZ(), -*low};
}

}  // namespace sgraph
