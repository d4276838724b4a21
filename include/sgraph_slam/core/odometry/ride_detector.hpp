#pragma once

#include <array>

#include <Eigen/Core>

#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// Whether a scan looks like one from a lift's cabin: all that is seen lies within 3 m on walls that go straight up, but for a door on one side.
/// `up`: unit vertical in odom.
bool like_a_cabin(const Cloud& cloud, const Pose& T_odom_lidar, const Eigen::Vector3d& up);

/// Tells a ride in a lift from what the scans show. While the doors are shut nothing but the cabin is seen; how far it goes up or down isn't seen at
/// all. When they open on another floor, what is seen through them isn't what was seen through them before. Where it is, the doors had only shut and
/// opened again.
class RideDetector {
 public:
  /// What opened doors show. Where another door opens than the one before, there is nothing to compare and nothing is said.
  enum class Seen { nothing, same_floor, another_floor, another_door };

  /// Takes the next scan; anything but `nothing` once after the doors have opened. `deskewed`: LiDAR frame; `up`: unit vertical in odom.
  Seen see(const Cloud& deskewed, const Pose& T_odom_lidar, const Eigen::Vector3d& up);

  /// Whether the robot is in something like a cabin.
  [[nodiscard]] bool inside() const { return inside_; }
  /// Whether the robot is in a cabin whose doors have been shut for as long as a ride takes, and it isn't known yet where they open: what is seen
  /// beyond the cabin may belong to another floor.
  [[nodiscard]] bool shut() const;
  /// The points of a scan that lie within the cabin.
  [[nodiscard]] CloudPtr within_cabin(const Cloud& deskewed, const Pose& T_odom_lidar) const;

 private:
  static constexpr int sectors = 72;
  static constexpr int columns = 180;  // of what was seen through the doors,
  static constexpr int rows = 24;      // by elevation

  // As seen from `position_`.
  struct Bearing {
    int sector;
    int column;
    int row;
    double range;   // on the ground [m]
    double height;  // [m]
  };
  [[nodiscard]] Bearing bearing(const Eigen::Vector3d& in_odom) const;
  [[nodiscard]] double wall(int sector) const;
  [[nodiscard]] bool beyond_walls(const Bearing& b) const;
  void enter(const Eigen::Vector3d& position);
  void tighten(const Cloud& deskewed, const Pose& T_odom_lidar);
  void remember(const Cloud& deskewed, const Pose& T_odom_lidar);
  [[nodiscard]] bool shows_cabin_alone(const Cloud& deskewed, const Pose& T_odom_lidar) const;
  void look_beyond(const Cloud& deskewed, const Pose& T_odom_lidar);

  bool inside_ = false;                                 // of something like a cabin
  int shut_for_ = 0;                                    // scans
  Eigen::Vector3d position_ = Eigen::Vector3d::Zero();  // of the sensor in it, odom
  Eigen::Vector3d up_ = Eigen::Vector3d::UnitZ();
  std::array<double, sectors> walls_{};                     // nearest that the farthest point was, on the ground [m]; 0: not seen
  std::array<std::array<double, rows>, columns> before_{};  // the farthest point, on the ground, before the doors shut [m]
  int known_ = 0;                                           // points beyond the cabin that are where they were before the doors shut,
  int unknown_ = 0;                                         // and that aren't
};

}  // namespace sgraph
