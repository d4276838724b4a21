#pragma once

#include <Eigen/Core>

#include "sgraph_slam/core/types/pose.hpp"
#include "sgraph_slam/core/types/stamp.hpp"

namespace sgraph {

/// One reading of an inertial unit, already turned into the base frame.
struct ImuSample {
  Stamp stamp;
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();     ///< [rad/s]
  Eigen::Vector3d linear_acceleration = Eigen::Vector3d::Zero();  ///< specific force [m/s^2]
};

/// One pose of another odometry (wheel or leg encoders, another program).
struct OdometrySample {
  Stamp stamp;
  Pose T_odom_base;
  Matrix6 covariance = Matrix6::Zero();  ///< of the pose: rotation, translation; zero when the source doesn't tell
};

}  // namespace sgraph
