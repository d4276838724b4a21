#pragma once

#include <random>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/segments.hpp"

namespace sgraph {

/// One face of a wall on the ground, from a to b with its free side on the left hand, solid but for its doors.
struct BuildingFace {
  Eigen::Vector2d a = Eigen::Vector2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
};

/// What a keyframe sees, and which face (index; -1 floor, -2 ceiling) each segment is really of.
struct SeenKeyframe {
  Keyframe keyframe;
  PlaneSegments segments;
  std::vector<int> faces;
  Pose T_world_base;  ///< truth
};

struct BuildingNoise {
  double range = 0.02;               ///< of a point [m]
  double odometry_angle = 0.0005;    ///< white, a step [rad]
  double odometry_distance = 0.003;  ///< white, a step [m]
  double odometry_scale = 0;         ///< of the way
  double odometry_heading = 0;       ///< drift [rad/m]
  bool clouds = false;               ///< keyframes have clouds, for loop closing
};

/// A building drawn by hand and a robot that walks through it with the noise of fits and of odometry, for tests of the mapping without the stages
/// before it. Walls are seen where nothing stands between, as clusters of noisy points to which planes are fitted.
class MappedBuilding {
 public:
  static constexpr double height = 2.6;
  static constexpr double sensor_height = 0.6;

  /// A wall's face, with doors as [from, to] along it.
  void add_face(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const std::vector<Eigen::Vector2d>& doors = {});
  /// Four faces around a rectangle, looking inside. Doors: of the -y, +x, +y and -x side, along the counter-clockwise direction.
  void add_room(double x0, double y0, double x1, double y1, const std::vector<std::vector<Eigen::Vector2d>>& doors);

  /// Walks along the waypoints, a keyframe every `step` [m] and at each corner. The odometry starts at the first one at `start_yaw` [rad] to its
  /// world.
  [[nodiscard]] std::vector<SeenKeyframe> walk(const std::vector<Eigen::Vector2d>& waypoints, double step, double start_yaw,
                                               const BuildingNoise& noise, unsigned seed) const;

  [[nodiscard]] const std::vector<BuildingFace>& faces() const { return faces_; }
  /// LiDAR on the robot.
  [[nodiscard]] static Pose T_base_lidar();

 private:
  void see(const Pose& T_world_base, const BuildingNoise& noise, std::mt19937& random, SeenKeyframe& seen) const;
  [[nodiscard]] CloudPtr cloud_from(const Pose& T_world_base) const;
  [[nodiscard]] bool visible(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;

  std::vector<BuildingFace> faces_;
  std::vector<int> wall_of_;  ///< pieces of one face, interrupted by doors, have one number
};

/// A plane fitted to points in the LiDAR's frame, as the segmentation gives it.
PlaneSegment fit_segment(const std::vector<Eigen::Vector3d>& points, double sigma);

}  // namespace sgraph
