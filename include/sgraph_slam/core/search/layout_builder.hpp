#pragma once

#include <vector>

#include "sgraph_slam/core/planes/outline.hpp"
#include "sgraph_slam/core/planes/wall.hpp"
#include "sgraph_slam/core/search/layout.hpp"
#include "sgraph_slam/core/types/ids.hpp"

namespace sgraph {

/// What is up by floors and ceilings: the mean of their normals, weighed by area.
class Upward {
 public:
  void add(const Eigen::Vector3d& normal, double area);
  /// Rotation that makes the floors level; none where no floor of half a square metre has been seen.
  [[nodiscard]] Eigen::Quaterniond level() const;

 private:
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
};

/// Puts walls, and what lay open before them, together to what is seen from above. Walls and views that are too low to be walls are left out.
class LayoutBuilder {
 public:
  static constexpr double tilt = 0.2618;            ///< largest of a wall from the vertical, of a floor from the horizontal [rad]
  static constexpr double wall_gap = 0.3;           ///< shorter gaps in a wall count as seen [m]
  static constexpr double least_height = 0.9;       ///< of a wall of a map [m]: desks and sofas are lower and move
  static constexpr double least_view_height = 0.6;  ///< of one view of a wall [m]: from near, a LiDAR's beams show a narrow band
  static constexpr std::size_t least_views = 2;     ///< of a wall of a map
  static constexpr int map_votes = 2;               ///< sights that call a place of a map free
  static constexpr int query_votes = 1;             ///< of what was seen on a few metres

  /// `level`: rotation of the frame of what is added into a level one. `T_base_lidar`: of the robot.
  LayoutBuilder(const Eigen::Quaterniond& level, const Pose& T_base_lidar) : T_level_{level, Eigen::Vector3d::Zero()}, T_base_lidar_(T_base_lidar) {}

  /// A view: where the robot was, and what it saw of the plane in its base frame.
  struct View {
    Pose T_map_base;
    const Outline* outline_base;
  };
  /// A plane of a map with views of it; `fewest`: of a wall that counts.
  void add_plane(PlaneId id, const Plane& plane, const std::vector<View>& views, std::size_t fewest = least_views);

  /// One view by itself, with the plane as it was fitted, in the LiDAR's frame.
  void add_segment(const Plane& plane_lidar, const Outline& outline_lidar, const Pose& T_map_base);

  [[nodiscard]] Layout build(int votes) { return {std::move(pieces_), sights_, votes}; }

 private:
  void add_pieces(const Wall& wall);
  void add_sight(const Wall& view, const Eigen::Vector3d& sensor);

  Pose T_level_;
  Pose T_base_lidar_;
  std::vector<WallPiece> pieces_;
  std::vector<Sight> sights_;
};

}  // namespace sgraph
