#include "sgraph_slam/core/registration/rigid_alignment.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

using Eigen::Vector3d;

struct Step {
  Matrix6 h = Matrix6::Zero();
  Vector6 b = Vector6::Zero();
  int inliers = 0;
  Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
};

// Residuals of the points moved by `correction`, linearised at a turn about `center` and a shift.
Step linearise(const SurfaceMap& map, const std::vector<SeenPoint>& points, const Pose& correction, const Vector3d& center, double kernel,
               double noise, Reach reach) {
  Step step;
  const double k2 = kernel * kernel;
  const double information = 1.0 / (noise * noise);
  const Eigen::Matrix3d rotation = correction.matrix();
  for (const SeenPoint& seen : points) {
    const Vector3d p = rotation * seen.point + correction.translation;
    const Vector3d sensor = rotation * seen.sensor + correction.translation;
    const Surface* surface = map.match(p, sensor, 2.0 * kernel, reach);
    if (surface == nullptr) continue;
    const double r = surface->normal.dot(p - surface->mean);
    const double r2 = r * r;
    if (r2 < k2) {
      ++step.inliers;
      step.normals += surface->normal * surface->normal.transpose();
    }
    const double share = k2 / (k2 + r2);
    const double w = share * share * information;
    Vector6 u;
    u << (p - center).cross(surface->normal), surface->normal;
    step.h.noalias() += w * u * u.transpose();
    step.b += (w * r) * u;
  }
  return step;
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

  for (int i = 0; i < options.iterations; ++i) {
    const double along = options.iterations > 1 ? static_cast<double>(i) / (options.iterations - 1) : 1.0;
    const double kernel = options.kernel_begin * std::pow(options.kernel_end / options.kernel_begin, along);
    const Step at = linearise(map, points, result.correction, center, kernel, options.noise, options.reach);
    result.inlier_share = static_cast<double>(at.inliers) / static_cast<double>(points.size());
    result.support = support_of(at.normals / static_cast<double>(points.size()));
    Matrix6 held;
    result.free_directions = weak_directions(at.h, options.arm, options.held_sigma, &held);
    Matrix6 h = at.h;
    h.diagonal().array() += 1e-6;  // the weak directions are projected away; this only keeps the solution finite
    const Vector6 step = -held * h.ldlt().solve(at.b);
    if (!step.allFinite()) break;
    const Eigen::Quaterniond turn = so3_exp(step.head<3>());
    const Pose move{turn, center - turn * center + step.tail<3>()};
    result.correction = move * result.correction;
    center = move * center;
  }
  result.held_directions = 6 - static_cast<int>(result.free_directions.size());
  result.rotation = so3_log(result.correction.rotation).norm();
  result.translation = (result.correction * begin - begin).norm();
  return result;
}

}  // namespace sgraph
