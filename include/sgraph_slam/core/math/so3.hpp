#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace sgraph {

/// The matrix with `skew(a) * b = a x b`.
Eigen::Matrix3d skew(const Eigen::Vector3d& a);

/// Rotation by the angle |phi| [rad] about phi.
Eigen::Quaterniond so3_exp(const Eigen::Vector3d& phi);

/// Rotation vector of q, |phi| <= pi; q and -q give the same.
Eigen::Vector3d so3_log(const Eigen::Quaterniond& q);

/// Right Jacobian: `exp(phi + delta) = exp(phi) exp(J_r delta)` to first order.
Eigen::Matrix3d so3_right_jacobian(const Eigen::Vector3d& phi);
Eigen::Matrix3d so3_right_jacobian_inverse(const Eigen::Vector3d& phi);

/// Angle of the rotation from a to b [rad], 0..pi.
double rotation_angle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b);

/// Heading of the x axis seen from above [rad].
double yaw_of(const Eigen::Quaterniond& q);

/// Two unit vectors that complete the unit vector n to a right-handed orthonormal frame (columns b1, b2 with b1 x b2 = n). Same n, same basis;
/// continuous except at one direction (Duff et al. 2017).
Eigen::Matrix<double, 3, 2> tangent_basis(const Eigen::Vector3d& n);

}  // namespace sgraph
