#pragma once

#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// Group exponential and logarithm of SE(3); a tangent vector is [rotation; translation].
Pose se3_exp(const Vector6& xi);
Vector6 se3_log(const Pose& pose);

/// `T exp(xi) T^-1 = exp(Ad_T xi)`.
Matrix6 se3_adjoint(const Pose& pose);

/// Inverse of the right Jacobian: `log(exp(xi) exp(delta)) = xi + J_r^-1 delta` to first order.
Matrix6 se3_right_jacobian_inverse(const Vector6& xi);

/// Pose a fraction of the way from a (0) to b (1): constant angular velocity, straight line. Extrapolates outside 0..1.
Pose interpolate(const Pose& a, const Pose& b, double fraction);

/// Pose at a stamp on a trajectory in order of stamp; the nearest end's pose outside it. The trajectory must not be empty.
Pose pose_at(const Trajectory& trajectory, Stamp stamp);

}  // namespace sgraph
