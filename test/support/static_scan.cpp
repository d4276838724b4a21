#include "static_scan.hpp"

#include <cmath>

#include "sgraph_slam/core/util/rng.hpp"
#include "sgraph_slam/core/util/voxel_set.hpp"

namespace sgraph::test {

sim::Surface rectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& edge_a, const Eigen::Vector3d& edge_b) {
  sim::Surface surface;
  surface.outline = {corner, corner + edge_a, corner + edge_a + edge_b, corner + edge_b};
  return surface;
}

std::vector<sim::Surface> box(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  std::vector<sim::Surface> sides;
  const Eigen::Vector3d size = high - low;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d a = size[(axis + 1) % 3] * Eigen::Vector3d::Unit((axis + 1) % 3);
    const Eigen::Vector3d b = size[(axis + 2) % 3] * Eigen::Vector3d::Unit((axis + 2) % 3);
    sides.push_back(rectangle(low, a, b));
    sides.push_back(rectangle(high, -a, -b));
  }
  return sides;
}

Cloud static_scan(const sim::Scene& scene, const Pose& T_world_lidar, double noise, std::uint64_t seed, double time) {
  RandomStream random(seed, 77);
  Cloud cloud;
  cloud.stamp = Stamp::from_seconds(100);
  cloud.frame = "velodyne";
  for (int column = 0; column < 1800; ++column) {
    sim::RayPacket rays;
    std::array<Eigen::Vector3d, sim::packet_size> directions;
    for (int ring = 0; ring < 16; ++ring) {
      const auto k = static_cast<std::size_t>(ring);
      const double azimuth = -2 * M_PI * column / 1800, elevation = (-15 + 2 * ring) * M_PI / 180;
      directions[k] = {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
      rays.origin[k] = T_world_lidar.translation;
      rays.direction[k] = T_world_lidar.rotation * directions[k];
      rays.active[k] = true;
    }
    const sim::HitPacket hits = scene.cast(rays);
    for (int ring = 0; ring < 16; ++ring) {
      const auto k = static_cast<std::size_t>(ring);
      if (!std::isfinite(hits.distance[k])) continue;
      const Eigen::Vector3f p = ((hits.distance[k] + noise * random.next_normal()) * directions[k]).cast<float>();
      Point point;
      point.x = p.x();
      point.y = p.y();
      point.z = p.z();
      point.time = static_cast<float>(time);
      point.ring = static_cast<std::uint16_t>(ring);
      cloud.points.push_back(point);
    }
  }
  return cloud;
}

Cloud keyframe_scan(const sim::Scene& scene, const std::vector<Pose>& T_world_lidar, double noise, std::uint64_t seed) {
  Cloud result;
  result.stamp = Stamp::from_seconds(100);
  VoxelSet taken(0.05, 29000 * T_world_lidar.size());
  for (std::size_t k = 0; k < T_world_lidar.size(); ++k) {
    const double time = -0.1 * static_cast<double>(T_world_lidar.size() - 1 - k);
    const Pose motion = T_world_lidar.back().inverse() * T_world_lidar[k];
    result.viewpoints.push_back({time, motion.translation});
    for (Point point : static_scan(scene, T_world_lidar[k], noise, seed * 1000 + k, time).points) {
      const Eigen::Vector3f p = (motion * point.position().cast<double>()).cast<float>();
      if (!taken.insert(p.x(), p.y(), p.z())) continue;
      point.x = p.x();
      point.y = p.y();
      point.z = p.z();
      result.points.push_back(point);
    }
  }
  return result;
}

}  // namespace sgraph::test
