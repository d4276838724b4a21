#pragma once

#include <cmath>

#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// A map of one room, 6 m along x and 4 m along y about the map's origin, 2.5 m high, floor at z = 0, with a door 1 m wide in the wall at x = +3
/// (y from 0.5 to 1.5, 2 m high); one keyframe whose LiDAR is at (0, -1, 1), its base half a metre below. The whole world is turned by `yaw`.
class SmallRoom {
 public:
  static constexpr double half_x = 3;
  static constexpr double half_y = 2;
  static constexpr double ceiling = 2.5;

  explicit SmallRoom(double yaw = 0) : turn_{Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), Eigen::Vector3d::Zero()} {
    snapshot.dominant_yaw = yaw;
    SceneKeyframe keyframe;
    keyframe.id = {0};
    keyframe.stamp = {1'700'000'000'123'456'789};
    keyframe.T_map_base = turn_ * Pose{Eigen::Quaterniond::Identity(), {0, -1, 0.5}};
    keyframe.scans = Trajectory{{keyframe.stamp, keyframe.T_odom_base}};
    keyframe.cloud = cloud();
    snapshot.keyframes.emplace(keyframe.id, keyframe);
    add_plane({0, 0, 1}, 0, PlaneClass::horizontal, {{-3, -2, 0}, {3, -2, 0}, {3, 2, 0}, {-3, 2, 0}});
    add_plane({1, 0, 0}, half_x, PlaneClass::x, wall({-3, 2}, {-3, -2}));
    add_plane({-1, 0, 0}, half_x, PlaneClass::x, wall({3, -2}, {3, 2}));
    add_plane({0, 1, 0}, half_y, PlaneClass::y, wall({-3, -2}, {3, -2}));
    add_plane({0, -1, 0}, half_y, PlaneClass::y, wall({3, 2}, {-3, 2}));
    SceneRoom room;
    room.id = {7};
    room.center = turn_ * Eigen::Vector3d(0, 0, 1.25);
    room.width = {6, 4};
    room.yaw = yaw;
    room.planes = {{1}, {2}, {3}, {4}};
    snapshot.rooms.emplace(room.id, room);
  }

  [[nodiscard]] Pose T_base_lidar() const { return {Eigen::Quaterniond::Identity(), {0, 0, 0.5}}; }
  /// A point of the unturned room in the map.
  [[nodiscard]] Eigen::Vector2d at(double x, double y) const { return (turn_ * Eigen::Vector3d(x, y, 0)).head<2>(); }

  GraphSnapshot snapshot;

 private:
  static std::vector<Eigen::Vector3d> wall(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return {{a.x(), a.y(), 0}, {b.x(), b.y(), 0}, {b.x(), b.y(), ceiling}, {a.x(), a.y(), ceiling}};
  }

  void add_plane(const Eigen::Vector3d& normal, double d, PlaneClass plane_class, const std::vector<Eigen::Vector3d>& extent) {
    ScenePlane plane;
    plane.id = {static_cast<std::int64_t>(snapshot.planes.size())};
    plane.plane = turn_ * Plane{normal, d};
    plane.plane_class = plane_class;
    for (const auto& corner : extent) plane.extent.push_back(turn_ * corner);
    plane.keyframes = {{0}};
    snapshot.planes.emplace(plane.id, plane);
  }

  // Rays every half a degree from -40 to +40 degrees of elevation; through the door they end on a wall 3 m behind it.
  static CloudPtr cloud() {
    auto cloud = std::make_shared<Cloud>();
    const Eigen::Vector3d origin(0, -1, 1);
    for (int a = 0; a < 720; ++a) {
      for (int e = -40; e <= 40; e += 2) {
        const double azimuth = (a + 0.3) * M_PI / 360;
        const double elevation = e * M_PI / 180;
        const Eigen::Vector3d d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
        double t = d.z() < -1e-9 ? -origin.z() / d.z() : d.z() > 1e-9 ? (ceiling - origin.z()) / d.z() : 1e9;
        t = std::min(t, ((d.y() > 0 ? half_y : -half_y) - origin.y()) / d.y());
        double at_wall = ((d.x() > 0 ? half_x : -half_x) - origin.x()) / d.x();
        const Eigen::Vector3d p = origin + at_wall * d;
        if (d.x() > 0 && p.y() > 0.5 && p.y() < 1.5 && p.z() < 2 && at_wall < t) {
          at_wall = (2 * half_x - origin.x()) / d.x();
          t = std::min(at_wall, d.z() < -1e-9 ? -origin.z() / d.z() : 1e9);
        }
        t = std::min(t, at_wall);
        Point point;
        point.x = static_cast<float>(t * d.x());
        point.y = static_cast<float>(t * d.y());
        point.z = static_cast<float>(t * d.z());
        point.intensity = static_cast<float>(a);
        cloud->points.push_back(point);
      }
    }
    cloud->points.push_back({});
    cloud->points.back().x = std::numeric_limits<float>::quiet_NaN();
    return cloud;
  }

  Pose turn_;
};

}  // namespace sgraph
