#include "sgraph_slam/core/io/map_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "sgraph_slam/core/math/outline_area.hpp"
#include "voxel_means.hpp"

namespace sgraph {
namespace {

// Whether a sensor at two poses puts all that it sees at most so far apart.
bool is_near(const Pose& a, const Pose& b, double distance) {
  constexpr double reach = 20;  // of what is seen [m]
  return (a.translation - b.translation).norm() + reach * 2 * (a.rotation.conjugate() * b.rotation).vec().norm() < distance;
}

// Calls `visit(p_map, point)` for each finite point of a keyframe's cloud, times taken out.
template <class Visit>
void visit_points(const Cloud& cloud, const Pose& T_map_lidar, Visit visit) {
  const Eigen::Matrix3d rotation = T_map_lidar.matrix();
  for (const Point& point : cloud.points) {
    if (!point.position().allFinite()) continue;
    Point moved = point;
    moved.time = 0;
    visit(Eigen::Vector3d(rotation * point.position().cast<double>() + T_map_lidar.translation), moved);
  }
}

}  // namespace

class LiveMapCloud::Implementation : public VoxelMeans {
 public:
  using VoxelMeans::VoxelMeans;
  std::map<KeyframeId, Pose> poses;
};

LiveMapCloud::LiveMapCloud(double leaf) : leaf_(leaf), voxels_(std::make_unique<Implementation>(leaf)) {}
LiveMapCloud::~LiveMapCloud() = default;

void LiveMapCloud::update(const GraphSnapshot& snapshot, const Pose& T_base_lidar) {
  const auto is_gone = [&snapshot](const auto& known) { return snapshot.keyframes.count(known.first) == 0; };
  if (std::any_of(voxels_->poses.begin(), voxels_->poses.end(), is_gone)) voxels_ = std::make_unique<Implementation>(leaf_);  // another map
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    const Pose now = keyframe.T_map_base * T_base_lidar;
    const auto before = voxels_->poses.find(id);
    if (before != voxels_->poses.end() && is_near(before->second, now, 0.5 * leaf_)) continue;
    const CloudPtr cloud = keyframe.cloud.get();
    if (!cloud) continue;
    if (before != voxels_->poses.end())
      visit_points(*cloud, before->second, [this](const Eigen::Vector3d& p, const Point& point) { voxels_->add(p, point, -1); });
    visit_points(*cloud, now, [this](const Eigen::Vector3d& p, const Point& point) { voxels_->add(p, point); });
    voxels_->poses[id] = now;
  }
}

Cloud LiveMapCloud::cloud() const {
  Cloud map;
  map.points = voxels_->points();
  return map;
}

Cloud map_cloud(const GraphSnapshot& snapshot, const Pose& T_base_lidar, double leaf, const LeaveOut& left_out) {
  Cloud map;
  map.frame = snapshot.frame;
  VoxelMeans voxels(leaf);
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    const CloudPtr cloud = keyframe.cloud.get();
    if (!cloud) continue;
    map.stamp = keyframe.stamp;
    visit_points(*cloud, keyframe.T_map_base * T_base_lidar, [&](const Eigen::Vector3d& p, Point& point) {
      if (left_out && left_out(p)) return;
      if (leaf > 0) {
        voxels.add(p, point);
      } else {
        point.set_position(p.cast<float>());
        map.points.push_back(point);
      }
    });
  }
  if (leaf > 0) map.points = voxels.points();
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
  const CloudPtr cloud = keyframe.cloud.get();
  if (!cloud) return std::nullopt;
  std::vector<double> heights;
  for (const Point& point : cloud->points) {
    if (point.position().allFinite()) heights.push_back((T_map_lidar * point.position().cast<double>()).z());
  }
  if (heights.empty()) return std::nullopt;
  // A few points lie below any floor: reflections, and what is seen through a stairwell.
  const auto low = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 50);
  std::nth_element(heights.begin(), low, heights.end());
  return Plane{Eigen::Vector3d::UnitZ(), -*low};
}

}  // namespace sgraph
