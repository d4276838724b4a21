#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "sgraph_slam/core/types/pose.hpp"
#include "sgraph_slam/core/types/sensor.hpp"

namespace sgraph {

/// How the LiDAR moved between two moments, as another sensor says.
struct MeasuredMotion {
  Pose motion;                            ///< of the LiDAR: from its frame at the end to that at the begin
  Matrix6 information = Matrix6::Zero();  ///< rotation, translation in the LiDAR's axes; zero in what isn't measured
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

  /// Of the gyro, base frame [rad/s].
  [[nodiscard]] const Eigen::Vector3d& gyro_bias() const { return bias_; }

 private:
  [[nodiscard]] std::optional<Eigen::Quaterniond> base_rotation_by_gyro(Stamp begin, Stamp end) const;
  [[nodiscard]] std::optional<Pose> base_motion_by_odometry(Stamp begin, Stamp end) const;
  [[nodiscard]] Pose of_lidar(const Pose& motion_of_base) const { return T_base_lidar_.inverse() * motion_of_base * T_base_lidar_; }

  Pose T_base_lidar_;
  std::deque<OdometrySample> odometry_;  // in order of stamp, the last few seconds
  std::deque<ImuSample> gyro_;
  Eigen::Vector3d bias_ = Eigen::Vector3d::Zero();
  double bias_variance_ = 4e-4;  // an axis [rad^2/s^2]
  double disagreement_ = 1;      // mean square of what the gyro is off, in standard deviations
};

}  // namespace sgraph
