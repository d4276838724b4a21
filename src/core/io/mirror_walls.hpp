#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "ray_origins.hpp"
#include "sgraph_slam/core/types/scene.hpp"
#include "voxel_key.hpp"

/// The walls of a map as `MirrorImages` looks through them, and what is seen through their holes.
namespace sgraph::mirrors {

inline constexpr double voxel = 0.1;        // in which points count as seen [m]
inline constexpr double cell = 0.1;         // of the raster on a wall [m]
inline constexpr double on_wall = 0.06;     // of a wall's face: its noise [m]
inline constexpr double behind = 0.1;       // a wall's face, and no nearer, a point is seen through it [m]
inline constexpr double reach = 30;         // of the LiDAR before a wall [m]
inline constexpr int depths = 7;            // of a pane behind the wall's face that are tried: up to 0.3 m, half of a thick wall
inline constexpr double depth_step = 0.05;  // between them [m]
inline constexpr double farthest = 5e4;     // of a point that a voxel's number can tell [m]

inline std::uint64_t key_of(const Eigen::Vector3d& p) { return voxel_key(p.array() / voxel); }

/// Voxels in which something was seen.
class Seen {
 public:
  void add(const Eigen::Vector3d& p) {
    keys_.push_back(key_of(p));
    if (keys_.size() > 2 * settled_ + 1'000'000) settle();
  }
  void settle() {
    std::sort(keys_.begin(), keys_.end());
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
    settled_ = keys_.size();
  }
  /// In the voxel or one that the point is nearest to. Settled before.
  [[nodiscard]] bool near(const Eigen::Vector3d& p) const {
    const Eigen::Array3d at = p.array() / voxel - 0.5;
    for (int k = 0; k < 8; ++k) {
      if (std::binary_search(keys_.begin(), keys_.end(), voxel_key(at + Eigen::Array3d(k & 1, k >> 1 & 1, k >> 2)))) return true;
    }
    return false;
  }

 private:
  std::vector<std::uint64_t> keys_;
  std::size_t settled_ = 0;
};

/// A wall's face with a raster over its outline.
struct Wall {
  Plane plane;
  Eigen::Vector3d along, up;
  Eigen::Vector2d corner;  // of the raster, along and up [m]
  int columns = 0, rows = 0;
  double floor = std::numeric_limits<double>::infinity();  // lowest z beside it
  Eigen::AlignedBox3d box;
  std::vector<char> inside;
  std::vector<std::uint16_t> passes;  // rays through a cell
  std::vector<std::uint8_t> returns;  // bit k: something was seen where a pane would be k steps behind the face
  std::vector<int> hole;              // number of the hole that a cell belongs to; -1: none

  [[nodiscard]] std::optional<std::uint32_t> cell_at(const Eigen::Vector3d& p) const {
    const double column = (along.dot(p) - corner.x()) / cell;
    const double row = (up.dot(p) - corner.y()) / cell;
    if (!(column >= 0 && row >= 0 && column < columns && row < rows)) return std::nullopt;
    const std::size_t i = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
    if (inside[i] == 0) return std::nullopt;
    return static_cast<std::uint32_t>(i);
  }
};

/// Nothing when the plane is too small or no wall.
std::optional<Wall> wall_of(const ScenePlane& plane);
/// How low the floor lies beside each wall, by the keyframes near it; by the nearest one where none came near.
void find_floors(const GraphSnapshot& snapshot, const Pose& T_base_lidar, std::vector<Wall>& walls);

/// Where a ray meets a wall.
struct Meeting {
  std::uint32_t wall;
  std::uint32_t cell;
};

/// A point, map frame, and the walls that its ray passes or ends on.
struct Sight {
  Eigen::Vector3d eye;
  Eigen::Vector3d p;
  std::vector<Meeting> through;
  std::vector<Meeting> on;
};

/// The walls that a keyframe may see, by the direction in which they lie: a ray meets few of a building's walls.
class WallsAround {
 public:
  /// `moved`: how far from `center` the rays begin [m].
  WallsAround(const std::vector<Wall>& walls, const Eigen::Vector3d& center, double moved) : center_(center.head<2>()) {
    for (std::uint32_t w = 0; w < walls.size(); ++w) {
      if (walls[w].plane.distance(center) <= behind || walls[w].box.exteriorDistance(center) >= reach) continue;
      const Wall& wall = walls[w];
      // Its ends on the ground as seen from here, and how far beside them a ray that begins elsewhere may pass the same place.
      const double length = cell * wall.columns;
      const Eigen::Vector2d along = wall.along.head<2>().normalized();
      const Eigen::Vector2d normal = wall.plane.normal.head<2>().normalized();
      const double first = wall.corner.x() - along.dot(center_);
      const double distance = wall.plane.normal.dot(center) + wall.plane.d;
      const double nearest = std::hypot(distance, std::max({0.0, first, -first - length}));
      const double margin = moved + on_wall + std::abs(wall.plane.normal.z()) * wall.box.sizes().z();
      if (nearest <= 1.5 * margin) {  // all around
        for (std::vector<std::uint32_t>& sector : sectors_) sector.push_back(w);
        continue;
      }
      const double turn = std::asin(margin / nearest);
      const auto direction = [&](double at, double by) { return Eigen::Rotation2Dd(by) * (at * along - distance * normal); };
      // Seen from before it, a wall's axis runs from its first column, on the right or on the left.
      const double side = along.x() * normal.y() - along.y() * normal.x() > 0 ? 1 : -1;
      const int from = sector_of(direction(side > 0 ? first : first + length, -turn));
      const int to = sector_of(direction(side > 0 ? first + length : first, turn));
      for (int k = from;; k = (k + 1) % sectors) {
        sectors_[static_cast<std::size_t>(k)].push_back(w);
        if (k == to) break;
      }
    }
  }

  [[nodiscard]] const std::vector<std::uint32_t>& towards(const Eigen::Vector3d& p) const {
    return sectors_[static_cast<std::size_t>(sector_of(p.head<2>() - center_))];
  }

 private:
  static constexpr int sectors = 256;
  static constexpr double of_quarter = sectors / 4.0;

  // Grows with the angle from -pi; not evenly, but without an arcus tangent.
  static int sector_of(const Eigen::Vector2d& v) {
    const double sum = std::abs(v.x()) + std::abs(v.y());
    const double part = sum > 0 ? v.x() / sum : 1;  // 1 ahead, -1 behind
    const double around = v.y() < 0 ? part + 1 : 3 - part;
    return std::min(static_cast<int>(around * of_quarter), sectors - 1);
  }

  Eigen::Vector2d center_;
  std::array<std::vector<std::uint32_t>, sectors> sectors_;
};

/// Calls `visit(sight)` with every point of every keyframe.
template <class Visit>
void visit_sights(const GraphSnapshot& snapshot, const Pose& T_base_lidar, const std::vector<Wall>& walls, const Visit& visit) {
  Sight sight;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    const CloudPtr cloud = keyframe.cloud.get();
    if (!cloud) continue;
    const Pose T_map_lidar = keyframe.T_map_base * T_base_lidar;
    const RayOrigins origins(*cloud, T_map_lidar);
    const Eigen::Matrix3d rotation = T_map_lidar.matrix();
    double moved = 0;
    for (const Viewpoint& viewpoint : cloud->viewpoints) moved = std::max(moved, viewpoint.position.norm());
    const WallsAround around(walls, T_map_lidar.translation, moved);
    for (const Point& point : cloud->points) {
      if (!point.position().allFinite()) continue;
      sight.p = rotation * point.position().cast<double>() + T_map_lidar.translation;
      if (!(sight.p.cwiseAbs().maxCoeff() < farthest)) continue;
      sight.eye = origins.of(point);
      sight.through.clear();
      sight.on.clear();
      for (const std::uint32_t w : around.towards(sight.p)) {
        const Wall& wall = walls[w];
        const double s = wall.plane.distance(sight.p);
        if (s > on_wall) continue;
        if (s > -on_wall) {
          if (const auto i = wall.cell_at(sight.p)) sight.on.push_back({w, *i});
          continue;
        }
        if (s > -behind) continue;
        const double before = wall.plane.distance(sight.eye);
        if (before < behind) continue;
        if (const auto i = wall.cell_at(sight.eye + before / (before - s) * (sight.p - sight.eye))) sight.through.push_back({w, *i});
      }
      visit(sight);
    }
  }
}

}  // namespace sgraph::mirrors
