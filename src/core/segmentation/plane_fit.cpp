#include "sgraph_slam/core/segmentation/plane_fit.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {

PlaneFit fit_plane(const Eigen::Matrix4d& scatter) {
  PlaneFit fit;
  const double count = scatter(3, 3);
  if (!(count >= 3)) return fit;
  fit.centroid = scatter.block<3, 1>(0, 3) / count;
  const Eigen::Matrix3d covariance = scatter.topLeftCorner<3, 3>() / count - fit.centroid * fit.centroid.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.compute(covariance);
  fit.spread = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  fit.plane.normal = solver.eigenvectors().col(0).normalized();
  fit.plane.d = -fit.plane.normal.dot(fit.centroid);
  fit.long_axis = solver.eigenvectors().col(2).normalized();
  // Coordinates of 100 m leave about 1e-6 m of the spread to rounding.
  fit.valid = fit.plane.normal.allFinite() && fit.long_axis.allFinite() && fit.spread[1] > 1e-5 + 1e-3 * fit.spread[0];
  return fit;
}

double mean_squared_distance(const Eigen::Matrix4d& scatter, const Plane& plane) {
  Eigen::Vector4d homogeneous;
  homogeneous << plane.normal, plane.d;
  return std::max(0.0, homogeneous.dot(scatter * homogeneous) / scatter(3, 3));
}

Eigen::Matrix3d plane_covariance(const Plane& plane, const Eigen::Matrix4d& scatter, double sigma) {
  Eigen::Matrix<double, 4, 3> J = Eigen::Matrix<double, 4, 3>::Zero();
  J.topLeftCorner<3, 2>() = tangent_basis(plane.normal);
  J(3, 2) = 1;
  const Eigen::Matrix3d information = J.transpose() * scatter * J;
  const Eigen::Matrix3d inverse = information.ldlt().solve(Eigen::Matrix3d::Identity());
  return sigma * sigma * 0.5 * (inverse + inverse.transpose());
}

}  // namespace sgraph
