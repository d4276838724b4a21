#include "sgraph_slam/core/registration/level_planes.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

// A ring's own errors, of which nothing averages out: two VLP-16s showed 6 and 10 mm, and up to 0.07 degrees (standard deviations).
constexpr double range_error = 0.008;       // [m]
constexpr double elevation_error = 0.0009;  // [rad]
// Of floors: how far they are from level, wherever.
constexpr double unevenness = 0.004;   // [m]
constexpr double plane_error = 0.002;  // [m] of a plane's height in its middle, and as far from there again as its points lie
constexpr double sigmas = 3.0;         // beyond which a point lies on something else

constexpr double same_height = 0.03;    // [m] of surfaces of one plane, when it is found
constexpr double level_cosine = 0.999;  // of a surface's normal to the vertical
constexpr std::size_t fewest = 15;      // surfaces of a metre's voxels: smaller ones are furniture

}  // namespace

Eigen::Vector3d LevelPlanes::coordinates(const Plane& plane, const Eigen::Vector3d& p) const {
  const Eigen::Vector3d d = p - plane.origin;
  return {x_.dot(d), y_.dot(d), 1.0};
}

void LevelPlanes::learn(Plane& plane, const Eigen::Vector3d& at, double height) {
  plane.information += at * at.transpose();
  plane.right += height * at;
}

void LevelPlanes::fit(Plane& plane) {
  const double n = plane.information(2, 2);
  if (n < 3) return;
  plane.middle = plane.information.col(2) / n;
  plane.radius2 = std::max(1.0, (plane.information(0, 0) + plane.information(1, 1)) / n - plane.middle.head<2>().squaredNorm());
  // A plane whose points lie on one line leans no way across it.
  Eigen::Matrix3d h = plane.information;
  h.diagonal().head<2>().array() += 1e-3 * n;
  plane.coefficients = h.ldlt().solve(plane.right);
}

void LevelPlanes::find(const std::vector<Surface>& surfaces, const Eigen::Vector3d& up) {
  if (planes_.empty()) {
    up_ = up;
    const Eigen::Matrix<double, 3, 2> level = tangent_basis(up);
    x_ = level.col(0);
    y_ = level.col(1);
  }
  std::vector<Eigen::Vector3d> means;
  for (const Surface& surface : surfaces) {
    if (std::abs(surface.normal.dot(up_)) < level_cosine) continue;
    const bool known = std::any_of(planes_.begin(), planes_.end(), [&](const Plane& plane) {
      return std::abs(height(plane, surface.mean) - plane.coefficients.dot(coordinates(plane, surface.mean))) < same_height;
    });
    if (!known) means.push_back(surface.mean);
  }
  std::sort(means.begin(), means.end(), [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return up_.dot(a) < up_.dot(b); });
  for (std::size_t i = 0; i + fewest <= means.size();) {
    std::size_t end = i;
    while (end < means.size() && up_.dot(means[end] - means[i]) < same_height) ++end;
    if (end - i < fewest) {
      ++i;
      continue;
    }
    Plane plane;
    plane.origin = means[i];
    plane.coefficients.setZero();
    for (std::size_t k = i; k < end; ++k) learn(plane, coordinates(plane, means[k]), height(plane, means[k]));
    fit(plane);
    planes_.push_back(plane);
    i = end;
  }
}

Eigen::Vector3d LevelPlanes::settle(const Eigen::Vector3d& point, const Eigen::Vector3d& sensor, double noise) {
  Plane* nearest = nullptr;
  Eigen::Vector3d at;
  double off = 0;
  for (Plane& plane : planes_) {
    const Eigen::Vector3d here = coordinates(plane, point);
    const double distance = height(plane, point) - plane.coefficients.dot(here);
    if (nearest != nullptr && std::abs(distance) >= std::abs(off)) continue;
    nearest = &plane;
    at = here;
    off = distance;
  }
  if (nearest == nullptr || std::abs(off) > 0.1) return point;
  const Eigen::Vector3d ray = point - sensor;
  const double range = std::max(0.1, ray.norm());
  const double sine = std::abs(up_.dot(ray)) / range;
  const double ring = std::pow(range_error * sine, 2) + std::pow(elevation_error * range, 2) * (1 - sine * sine);
  const double spread = (at - nearest->middle).squaredNorm() / nearest->radius2;
  const double floor = unevenness * unevenness + plane_error * plane_error * (1 + spread);
  const double gate2 = sigmas * sigmas * (ring + floor + std::pow(noise * sine, 2));
  const double share = off * off / gate2;
  if (share >= 1) return point;
  learn(*nearest, at, height(*nearest, point));
  return point - std::pow(1 - share, 2) * ring / (ring + floor) * off * up_;
}

void LevelPlanes::update() {
  for (Plane& plane : planes_) fit(plane);
}

}  // namespace sgraph
