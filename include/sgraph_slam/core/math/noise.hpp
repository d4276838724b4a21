#pragma once

#include <Eigen/Core>

namespace sgraph {

/// The package's one model of a LiDAR point's error across the surface that it lies on, as measured on two VLP-16s and in buildings
/// (docs/sensors.md):
///
///   error = white part + what all points of a beam share + what all points of a patch of the surface share
///
/// The white part averages out over the points. A beam's errors average out over the beams only, and a surface's over its patches; taking them for
/// white makes thousands of points on a wall say more than they know, which is how a graph comes to make a good odometry worse.
namespace noise {

/// Error of a beam's range, shared by all of its points [m]. Standard deviation over the beams: 5.5 mm on one unit, 9.8 mm on another.
constexpr double beam_range = 0.008;

/// Error of a beam's elevation [rad]: 0.03 degrees.
constexpr double beam_elevation = 0.0005;

/// What a wall, floor or ceiling deviates from its plane within a patch [m]: 3 to 5 mm of texture, bow and waves.
constexpr double surface = 0.003;

/// Edge of a patch [m]: over half a metre a surface's deviation stays about the same.
constexpr double patch = 0.5;

/// The part of the variance of a point's distance from a *mapped* surface that the points of a patch share: the map's own error there.
constexpr double shared_in_patch = 0.25;

/// Least standard deviation of a point's distance from a mapped surface [m]: range noise and what the map doesn't know.
constexpr double mapped_surface = 0.015;

}  // namespace noise

/// How many times larger the variance of an estimate is than if its points' errors were independent, when `points` of them lie on each patch: the
/// design effect of cluster sampling, 1 + (m - 1) rho (Kish, Survey Sampling, 1965).
constexpr double patch_effect(double points) { return points > 1 ? 1 + (points - 1) * noise::shared_in_patch : 1; }

/// Points on a patch when one in a voxel of `leaf` [m] is kept.
constexpr double points_on_patch(double leaf) { return leaf > 0 && leaf < noise::patch ? noise::patch * noise::patch / (leaf * leaf) : 1; }

/// Covariance of a least-squares estimate x of residuals r_i = J_i x + s_i e_g, whose points i of a group g share the error e_g: the sandwich
/// H^-1 (sum over g of sigma_g^2 (sum s_i J_i)(sum s_i J_i)^T) H^-1 with H = sum J_i J_i^T.
template <int N>
class SharedErrors {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  /// `sum`: of s_i J_i over the group; `sigma`: standard deviation of what it shares.
  void add(const Vector& sum, double sigma) { middle_ += sigma * sigma * sum * sum.transpose(); }

  /// `inverse`: H^-1.
  [[nodiscard]] Matrix covariance(const Matrix& inverse) const { return inverse * middle_ * inverse; }

 private:
  Matrix middle_ = Matrix::Zero();
};

}  // namespace sgraph
