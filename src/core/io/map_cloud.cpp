#include "sgraph_slam/core/io/map_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <vector>

#include "sgraph_slam/core/math/outline_area.hpp"

namespace sgraph {
namespace {

// Whether a sensor at two poses puts all that it sees at most so far apart.
bool is_near(const Pose& a, const Pose& b, double distance) {
  constexpr double reach = 20;  // of what is seen [m]
  return (a.translation - b.translation).norm() + reach * 2 * (a.rotation.conjugate() * b.rotation).vec().norm() < distance;
}

// A voxel with a smaller share of the points that a neighbour holds is the outer rim of that neighbour's noise, not a surface of its own.
constexpr double least_share = 0.1;

/// The mean of the points in each voxel, in the order in which the voxels were met.
class VoxelMeans {
 public:
  explicit VoxelMeans(double leaf) : leaf_(leaf) {}

  // `sign`: 1 to put a point in, -1 to take one out that was put in at the same place.
  void add(const Eigen::Vector3d& p, const Point& point, int sign = 1) {
    const auto [at, is_new] = index_.try_emplace(key_of(p), voxels_.size());
    if (is_new) voxels_.push_back({at->first, point});
    Voxel& voxel = voxels_[at->second];
    voxel.sum += sign * p;
    voxel.intensity += sign * static_cast<double>(point.intensity);
    voxel.count += sign;
  }

  [[nodiscard]] std::vector<Point> points() const {
    std::vector<Point> result;
    result.reserve(voxels_.size());
    for (const Voxel& voxel : voxels_) {
      if (voxel.count <= 0 || voxel.count < least_share * fullest_neighbour(voxel.key)) continue;
      Point point = voxel.first;
      point.set_position((voxel.sum / voxel.count).cast<float>());
      point.intensity = static_cast<float>(voxel.intensity / voxel.count);
      result.push_back(point);
    }
    return result;
  }

 private:
  struct Voxel {
    std::uint64_t key = 0;
    Point first;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double intensity = 0;
    int count = 0;
  };

  static constexpr int bits = 21;  // an axis: told apart up to a million leaves from the origin

  [[nodiscard]] std::uint64_t key_of(const Eigen::Vector3d& p) const {
    const auto axis = [this](double value) {
      return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(value / leaf_)) + (1 << (bits - 1))) & ((1U << bits) - 1);
    };
    return axis(p.x()) << (2 * bits) | axis(p.y()) << bits | axis(p.z());
  }

  // Of the six that share a side: whatever way a surface lies, the noise across it enters through one of them.
  [[nodiscard]] int fullest_neighbour(std::uint64_t key) const {
    int most = 0;
    for (const int axis : {0, 1, 2}) {
      const std::uint64_t step = std::uint64_t{1} << (axis * bits);
      for (const std::uint64_t neighbour : {key + step, key - step}) {
        const auto at = index_.find(neighbour);
        if (at != index_.end()) most = std::max(most, voxels_[at->second].count);
      }
    }
    return most;
  }

  double leaf_;
  std::unordered_map<std::uint64_t, std::size_t> index_;
  std::vector<Voxel> voxels_;
};

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
