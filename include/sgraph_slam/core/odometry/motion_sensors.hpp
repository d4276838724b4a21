#pragma once

#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "sgraph_slam/core/types/pose.hpp"
#include "sgraph_slam/core/types/sensor.hpp"

namespace sgraph {

/// How the LiDAR moved between two moments, as another sensor says.
struct MeasuredMotion {
  Pose motion;                            ///< of the LiDAR: from its frame at the end to that at the begin
  Matrix6 information = Matrix6::Zero();  ///< rotation, translation in the LiDAR's axes; zero in what isn't measured
};

/// Systematic errors of a robot's odometry: a true motion is `1 + scale` times as long as it says and turns by `(1 + turn) psi + bend d` where it
/// says psi over a length of d (wheels of other diameters than believed, another track width, unequal wheels).
struct OdometryErrors {
  double scale = 0;
  double turn = 0;
  double bend = 0;                                                                         ///< [rad/m]
  double scale_variance = 0.05 * 0.05;                                                     ///< before anything is known
  Eigen::Matrix2d turn_variance = Eigen::Vector2d(0.05 * 0.05, 0.02 * 0.02).asDiagonal();  ///< of turn and bend
};

/// Gyro and robot odometry as measurements of the LiDAR's motion. The gyro's bias is found by comparing it with motion known otherwise; one that
/// keeps disagreeing is no longer used.
class MotionSensors {
 public:
  explicit MotionSensors(const Pose& T_base_lidar) : T_base_lidar_(T_base_lidar) {}

  /// Readings that aren't later than the last of their kind, or not finite, are left out.
  void add(const OdometrySample& sample);
  void add(const ImuSample& sample);

  /// What is known of the motion between two moments: nothing, or one entry a sensor that covers them.
  [[nodiscard]] std::vector<MeasuredMotion> between(Stamp begin, Stamp end) const;

  /// Rotation of the LiDAR by the gyro, and its motion by the robot's odometry.
  [[nodiscard]] std::optional<Eigen::Quaterniond> rotation_by_gyro(Stamp begin, Stamp end) const;
  [[nodiscard]] std::optional<Pose> motion_by_odometry(Stamp begin, Stamp end) const;

  /// The LiDAR's rotation between two moments, known otherwise.
  void learn(Stamp begin, Stamp end, const Eigen::Quaterniond& turn);

  /// The LiDAR's pose in a frame that stands still, known otherwise: in every direction, or else not `known`. In order of stamp. Where the motion is
  /// known, the errors of the robot's odometry are found; they are taken out of what it says.
  void learn_motion(Stamp stamp, const Pose& T_odom_lidar, bool known);

  [[nodiscard]] const OdometryErrors& odometry_errors() const { return errors_; }

  /// Of the gyro, base frame [rad/s].
  [[nodiscard]] const Eigen::Vector3d& gyro_bias() const { return bias_; }

 private:
  [[nodiscard]] std::optional<Eigen::Quaterniond> base_rotation_by_gyro(Stamp begin, Stamp end) const;
  [[nodiscard]] std::optional<Pose> base_motion_by_odometry(Stamp begin, Stamp end) const;
  [[nodiscard]] std::optional<Pose> raw_base_motion(Stamp begin, Stamp end) const;
  void compare(const Pose& said, const Pose& known);
  [[nodiscard]] Pose of_lidar(const Pose& motion_of_base) const { return T_base_lidar_.inverse() * motion_of_base * T_base_lidar_; }

  Pose T_base_lidar_;
  std::deque<OdometrySample> odometry_;  // in order of stamp, the last few seconds
  std::deque<ImuSample> gyro_;
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
  double bias_variance_ = 4e-4;  // an axis [rad^2/s^2]
  OdometryErrors errors_;
  std::optional<std::pair<Stamp, Pose>> known_since_;  // where the motion that is being compared began: base in odom
  double disagreement_ = 1;                            // mean square of what the gyro is off, in standard deviations
};

}  // namespace sgraph
