#include "sgraph_slam/core/math/se3.hpp"

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Matrix3d so3_left_jacobian(const Vector3d& phi) { return so3_right_jacobian(-phi); }
Matrix3d so3_left_jacobian_inverse(const Vector3d& phi) { return so3_right_jacobian_inverse(-phi); }

// The coupling block of the left Jacobian of SE(3) (Barfoot, State Estimation for Robotics, 7.86b).
Matrix3d coupling(const Vector3d& phi, const Vector3d& rho) {
  const Matrix3d p = skew(phi);
  const Matrix3d r = skew(rho);
  const double a = phi.norm();
  const double a2 = a * a;
  double c1 = 1.0 / 6.0 - a2 / 120.0;
  double c2 = 1.0 / 24.0 - a2 / 720.0;
  double c3 = 1.0 / 120.0 - a2 / 2520.0;
  if (a > 0.1) {
    c1 = (a - std::sin(a)) / (a2 * a);
    c2 = (a2 + 2.0 * std::cos(a) - 2.0) / (2.0 * a2 * a2);
    c3 = (2.0 * a - 3.0 * std::sin(a) + a * std::cos(a)) / (2.0 * a2 * a2 * a);
  } else {  // next terms of the series, so that the branches meet to 1e-12
    const double a4 = a2 * a2;
    c1 += a4 / 5040.0;
    c2 += a4 / 40320.0;
    c3 += a4 / 120960.0;
  }
  return 0.5 * r + c1 * (p * r + r * p + p * r * p) + c2 * (p * p * r + r * p * p - 3.0 * p * r * p) + c3 * (p * r * p * p + p * p * r * p);
}

}  // namespace

Pose se3_exp(const Vector6& xi) {
  const Vector3d phi = xi.head<3>();
  return {so3_exp(phi), so3_left_jacobian(phi) * xi.tail<3>()};
}

Vector6 se3_log(const Pose& pose) {
  const Vector3d phi = so3_log(pose.rotation);
  Vector6 xi;
  xi << phi, so3_left_jacobian_inverse(phi) * pose.translation;
  return xi;
}

Matrix6 se3_adjoint(const Pose& pose) {
  const Matrix3d r = pose.matrix();
  Matrix6 m = Matrix6::Zero();
  m.topLeftCorner<3, 3>() = r;
  m.bottomRightCorner<3, 3>() = r;
  m.bottomLeftCorner<3, 3>() = skew(pose.translation) * r;
  return m;
}

Matrix6 se3_right_jacobian_inverse(const Vector6& xi) {
  const Vector3d phi = -xi.head<3>();
  const Vector3d rho = -xi.tail<3>();
  const Matrix3d j = so3_left_jacobian_inverse(phi);
  Matrix6 m = Matrix6::Zero();
  m.topLeftCorner<3, 3>() = j;
  m.bottomRightCorner<3, 3>() = j;
  m.bottomLeftCorner<3, 3>() = -j * coupling(phi, rho) * j;
  return m;
}

Pose interpolate(const Pose& a, const Pose& b, double fraction) {
  const Vector3d phi = so3_log(a.rotation.conjugate() * b.rotation);
  return {(a.rotation * so3_exp(fraction * phi)).normalized(), a.translation + fraction * (b.translation - a.translation)};
}

Pose pose_at(const Trajectory& trajectory, Stamp stamp) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), stamp, [](const StampedPose& p, Stamp s) { return p.stamp < s; });
  if (after == trajectory.end()) return trajectory.back().pose;
  if (after == trajectory.begin() || after->stamp == stamp) return after->pose;
  const auto before = std::prev(after);
  return interpolate(before->pose, after->pose, (stamp - before->stamp) / (after->stamp - before->stamp));
}

}  // namespace sgraph
