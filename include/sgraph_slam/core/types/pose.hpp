#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "sgraph_slam/core/types/stamp.hpp"

namespace sgraph {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// A rigid motion. `T_a_b` maps points of frame b into frame a: `p_a = T_a_b * p_b`.
struct Pose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit quaternion
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();         ///< [m]

  [[nodiscard]] Pose inverse() const {
    const Eigen::Quaterniond r = rotation.conjugate();
    return {r, -(r * translation)};
  }
  [[nodiscard]] Eigen::Matrix3d matrix() const { return rotation.toRotationMatrix(); }

  friend Pose operator*(const Pose& a, const Pose& b) { return {(a.rotation * b.rotation).normalized(), a.rotation * b.translation + a.translation}; }
  friend Eigen::Vector3d operator*(const Pose& a, const Eigen::Vector3d& p) { return a.rotation * p + a.translation; }
};

struct StampedPose {
  Stamp stamp;
  Pose pose;
};

using Trajectory = std::vector<StampedPose>;  ///< in order of stamp

}  // namespace sgraph
