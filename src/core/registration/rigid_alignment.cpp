#include "sgraph_slam/core/registration/rigid_alignment.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

using Eigen::Vector3d;

// What normals that are off by `sigma` each on its own make of the information by chance, to be taken from it: a normal's part u = J n has the
// expectation u u^T + sigma^2 J J^T when it is seen through such an error. Thousands of points on the sides of a bare corridor would hold the
// direction along it otherwise.
class ChanceInformation {
 public:
  void add(const Vector3d& arm, double weight) {
    weight_ += weight;
    first_ += weight * arm;
    second_.noalias() += (weight * arm) * arm.transpose();
  }

  [[nodiscard]] Matrix6 of(double sigma) const {
    Matrix6 jj;
    jj << second_.trace() * Eigen::Matrix3d::Identity() - second_, skew(first_), skew(first_).transpose(), weight_ * Eigen::Matrix3d::Identity();
    return sigma * sigma * jj;
  }

 private:
  double weight_ = 0;
  Vector3d first_ = Vector3d::Zero();
  Eigen::Matrix3d second_ = Eigen::Matrix3d::Zero();
};

// Into the lower half; the upper one is its mirror.
void add_outer_product(const Vector6& u, double weight, Matrix6& sum) {
  for (int j = 0; j < 6; ++j) {
    const double wu = weight * u[j];
    for (int i = j; i < 6; ++i) sum(i, j) += wu * u[i];
  }
}

struct Step {
  Matrix6 h = Matrix6::Zero();
  ChanceInformation chance;
  Vector6 b = Vector6::Zero();
  int inliers = 0;
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
};

// Residuals of the points moved by `correction`, linearised at a turn about `center` and a shift.
Step linearise(const SurfaceMap& map, const std::vector<SeenPoint>& points, const Pose& correction, const Vector3d& center, double kernel,
               const RigidAlignmentOptions& options, std::vector<CachedMatch>& matches) {
  Step step;
  const double k2 = kernel * kernel;
  const double information = 1.0 / (options.noise * options.noise);
  const Eigen::Matrix3d rotation = correction.matrix();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const SeenPoint& seen = points[i];
    const Vector3d p = rotation * seen.point + correction.translation;
    const Vector3d sensor = rotation * seen.sensor + correction.translation;
    const Surface* surface = matches[i].find(map, p, sensor, 2.0 * kernel, options.reach);
    if (surface == nullptr) continue;
    std::optional<Surface> stood;
    if (options.plumb_along) {
      stood = plumb(*surface, *options.plumb_along);
      if (!stood) continue;
      surface = &*stood;
    }
    const double r = surface->distance(p);
    const double r2 = r * r;
    if (r2 < k2) {
      ++step.inliers;
      step.normals += surface->normal * surface->normal.transpose();
    }
    const double share = k2 / (k2 + r2);
    const double w = share * share * information;
    Vector6 u;
    u << (p - center).cross(surface->normal), surface->normal;
    add_outer_product(u, w, step.h);
    step.b += (w * r) * u;
    step.chance.add(p - center, w);
  }
  step.h.triangularView<Eigen::StrictlyUpper>() = step.h.transpose();
  return step;
}

// Projection of a step onto turns about the vertical and shifts on the ground.
Matrix6 planar_steps(const Vector3d& up) {
  Matrix6 planar = Matrix6::Zero();
  planar.topLeftCorner<3, 3>() = up * up.transpose();
  planar.bottomRightCorner<3, 3>() = Eigen::Matrix3d::Identity() - up * up.transpose();
  return planar;
}

Matrix6 without_height(const Vector3d& up) {
  Matrix6 level = Matrix6::Identity();
  level.bottomRightCorner<3, 3>() -= up * up.transpose();
  return level;
}

// Geometric mean of the support in three directions. What little an open direction has is chance: below a floor all count the same.
double support_of(const Eigen::Matrix3d& normals) {
  constexpr double open = 0.03;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(normals, Eigen::EigenvaluesOnly);
  return std::cbrt(solver.eigenvalues().cwiseMax(open).prod());
}

}  // namespace

std::vector<Vector6> weak_directions(const Matrix6& information, double arm, double sigma, Matrix6* held) {
  Vector6 scale;
  scale << Vector3d::Constant(1.0 / arm), Vector3d::Ones();
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(scale.asDiagonal() * information * scale.asDiagonal());
  std::vector<Vector6> weak;
  Matrix6 projection = Matrix6::Zero();
  for (int i = 0; i < 6; ++i) {
    const Vector6 direction = solver.eigenvectors().col(i);
    if (solver.eigenvalues()[i] * sigma * sigma < 1.0) {
      weak.push_back((scale.asDiagonal() * direction).normalized());
    } else {
      projection += direction * direction.transpose();
    }
  }
  if (held != nullptr) *held = scale.asDiagonal() * projection * scale.cwiseInverse().asDiagonal();
  return weak;
}

RigidAlignmentResult align_rigidly(const SurfaceMap& map, const std::vector<SeenPoint>& points, const RigidAlignmentOptions& options) {
  RigidAlignmentResult result;
  if (points.empty()) return result;
  Vector3d center = Vector3d::Zero();
  for (const SeenPoint& seen : points) center += seen.sensor;
  center /= static_cast<double>(points.size());
  const Vector3d begin = center;
  result.correction = options.start;
  center = result.correction * center;

  std::vector<CachedMatch> matches(points.size());
  const auto advance = [&](double along) {
    const double kernel = options.kernel_begin * std::pow(options.kernel_end / options.kernel_begin, along);
    const Step at = linearise(map, points, result.correction, center, kernel, options, matches);
    result.inlier_share = static_cast<double>(at.inliers) / static_cast<double>(points.size());
    result.support = support_of(at.normals / static_cast<double>(points.size()));
    result.free_directions = weak_directions(at.h - at.chance.of(options.normal_sigma), options.arm, options.held_sigma, &result.held);
    Matrix6 h = at.h;
    h.diagonal().array() += 1e-6;  // the weak directions are projected away; this only keeps the solution finite
    Vector6 b = at.b;
    if (options.plumb_along) {
      result.held = planar_steps(*options.plumb_along);
      h = result.held * h * result.held + Matrix6::Identity() - result.held;
      b = result.held * b;
    }
    const Vector6 step = -result.held * h.ldlt().solve(b);
    if (!step.allFinite()) return false;
    const Eigen::Quaterniond turn = so3_exp(step.head<3>());
    const Pose move{turn, center - turn * center + step.tail<3>()};
    result.correction = move * result.correction;
    center = move * center;
    return true;
  };
  bool finite = true;
  for (int i = 0; finite && i < options.iterations; ++i)
    finite = advance(options.iterations > 1 ? static_cast<double>(i) / (options.iterations - 1) : 1.0);
  if (finite && !result.free_directions.empty()) {
    // Looked at through a wide kernel, wrong matches hold every direction. Only now is it seen which directions are free: what the sensor has moved
    // in them is undone, and the rest settles in two more steps.
    Vector6 moved;
    moved << so3_log(result.correction.rotation), center - begin;
    moved = (result.held * moved).eval();
    const Eigen::Quaterniond turn = so3_exp(moved.head<3>());
    center = begin + moved.tail<3>();
    result.correction = {turn, center - turn * begin};
    for (int i = 0; finite && i < 2; ++i) finite = advance(1.0);
  }
  if (options.plumb_along) result.held = without_height(*options.plumb_along);
  result.held_directions = 6 - static_cast<int>(result.free_directions.size());
  result.rotation = so3_log(result.correction.rotation).norm();
  result.moved = result.correction * begin - begin;
  result.translation = result.moved.norm();
  return result;
}

}  // namespace sgraph
