#include "sgraph_slam/core/math/so3.hpp"

#include <algorithm>
#include <cmath>

namespace sgraph {
namespace {

constexpr double small_angle = 1e-5;  // below it the series is exact to double precision

}  // namespace

Eigen::Matrix3d skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d m;
  m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return m;
}

Eigen::Quaterniond so3_exp(const Eigen::Vector3d& phi) {
  const double angle = phi.norm();
  const double half = 0.5 * angle;
  const double scale = angle < small_angle ? 0.5 - angle * angle / 48.0 : std::sin(half) / angle;
  const Eigen::Vector3d v = scale * phi;
  return Eigen::Quaterniond(std::cos(half), v.x(), v.y(), v.z()).normalized();
}

Eigen::Vector3d so3_log(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const Eigen::Vector3d v = sign * q.vec();
  const double w = sign * q.w();
  const double s = v.norm();
  if (s < small_angle) return (2.0 / w) * (1.0 - s * s / (3.0 * w * w)) * v;
  return (2.0 * std::atan2(s, w) / s) * v;
}

Eigen::Matrix3d so3_right_jacobian(const Eigen::Vector3d& phi) {
  const double a = phi.norm();
  const Eigen::Matrix3d w = skew(phi);
  if (a < small_angle) return Eigen::Matrix3d::Identity() - 0.5 * w + w * w / 6.0;
  const double a2 = a * a;
  return Eigen::Matrix3d::Identity() - (1.0 - std::cos(a)) / a2 * w + (a - std::sin(a)) / (a2 * a) * w * w;
}

Eigen::Matrix3d so3_right_jacobian_inverse(const Eigen::Vector3d& phi) {
  const double a = phi.norm();
  const Eigen::Matrix3d w = skew(phi);
  if (a < small_angle) return Eigen::Matrix3d::Identity() + 0.5 * w + w * w / 12.0;
  const double half = 0.5 * a;
  return Eigen::Matrix3d::Identity() + 0.5 * w + (1.0 - half * std::cos(half) / std::sin(half)) / (a * a) * w * w;
}

double rotation_angle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) { return so3_log(a.conjugate() * b).norm(); }

double yaw_of(const Eigen::Quaterniond& q) { return std::atan2(2.0 * (q.w() * q.z() + q.x() * q.y()), 1.0 - 2.0 * (q.y() * q.y() + q.z() * q.z())); }

Eigen::Matrix<double, 3, 2> tangent_basis(const Eigen::Vector3d& n) {
  const double sign = std::copysign(1.0, n.z());
  const double a = -1.0 / (sign + n.z());
  const double b = n.x() * n.y() * a;
  Eigen::Matrix<double, 3, 2> basis;
  basis.col(0) << 1.0 + sign * n.x() * n.x() * a, sign * b, -sign * n.x();
  basis.col(1) << b, sign + n.y() * n.y() * a, -n.y();
  return basis;
}

}  // namespace sgraph
