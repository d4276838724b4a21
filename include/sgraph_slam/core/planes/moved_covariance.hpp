#pragma once

#include <Eigen/Core>

#include "sgraph_slam/core/types/plane.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// Covariance of a plane (two angles in tangent_basis(normal); d [rad, rad, m]) taken from one frame to another, the transform known.
/// `in_target` is `T_target_source * in_source`, or an estimate of it.
Eigen::Matrix3d moved_covariance(const Pose& T_target_source, const Plane& in_source, const Plane& in_target, const Eigen::Matrix3d& covariance);

}  // namespace sgraph
