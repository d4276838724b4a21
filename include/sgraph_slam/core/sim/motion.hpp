#pragma once

#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/sim/world.hpp"

namespace sgraph::sim {

/// A floor that isn't flat.
struct FloorLevel {
  double z = 0;  ///< nominal [m]
  Unevenness shape;
};

/// The robot's true motion along a route: twice continuously differentiable, so that accelerations exist. Corners are rounded with a curvature that
/// rises and falls smoothly, speed keeps to the profile's limits of speed, acceleration, turn rate and turn acceleration, turns of more than 120
/// degrees and turns at waypoints with a wait are made on the spot. While it moves it sways. On stairs and ramps it
/// pitches with the slope, rounded over half a second.
class Motion {
 public:
  /// Throws WorldError: two equal waypoints in a row, or a wished duration that no speed reaches.
  Motion(const Route& route, const MotionProfile& profile, std::vector<FloorLevel> floors);
  /// On flat floors; the heights of the waypoints count from `floor_z` [m].
  Motion(const Route& route, const MotionProfile& profile, double floor_z);

  /// A walk recorded elsewhere: poses of base_link, at least four and at most a quarter of a second apart, joined smoothly (once continuously
  /// differentiable). The first stamp is time 0. Throws WorldError.
  explicit Motion(Trajectory recorded);

  /// From the first moment to the last [s].
  [[nodiscard]] double duration() const { return duration_; }
  /// Speed limit used, as given or as chosen for the route's duration; of a recorded walk its mean speed [m/s].
  [[nodiscard]] double speed_limit() const { return profile_.speed; }
  /// Length of the way over ground [m].
  [[nodiscard]] double length() const;

  /// Pose of base_link in the world; before the first moment and after the last the robot stands.
  [[nodiscard]] Pose pose_at(double time) const;
  /// Angular [rad/s] and linear [m/s] velocity in the base frame.
  [[nodiscard]] Vector6 twist_at(double time) const;
  /// Acceleration of the base's origin in the world, without gravity [m/s^2].
  [[nodiscard]] Eigen::Vector3d acceleration_at(double time) const;

 private:
  using Sample = Eigen::Matrix<double, 6, 1>;  // x, y, heading (unwrapped), share of the sway, z of the floor, slope along the way

  [[nodiscard]] Sample spline_at(double time) const;
  [[nodiscard]] Pose recorded_at(double time) const;

  MotionProfile profile_;
  std::vector<FloorLevel> floors_;
  double duration_ = 0;
  Trajectory recorded_;
  std::vector<Sample> control_;  // of a uniform cubic B-spline
};

/// The motion along the world's route, on the floor as it is.
Motion motion_along_route(const World& world);

}  // namespace sgraph::sim
