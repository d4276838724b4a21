#include "sgraph_slam/core/graph/factors/pose_plane_points.hpp"

#include <limits>

#include <Eigen/Dense>

#include "plane_observation.hpp"

namespace sgraph {

SqrtScatter sqrt_scatter(const Eigen::Matrix4d& scatter, double sigma_point, double floor_angle, double floor_distance) {
  const double count = scatter(3, 3);
  if (!scatter.allFinite() || !(sigma_point > 0) || !(floor_angle > 0) || !(floor_distance > 0) || !(count > 0)) {
    return SqrtScatter::Constant(std::numeric_limits<double>::quiet_NaN());
  }
  // Over unit normals, the sum of squared distances less its least value is again a quadratic form: take that value off the normal's block.
  const Eigen::Vector3d mean = scatter.topRightCorner<3, 1>() / count;
  const Eigen::Matrix3d central = scatter.topLeftCorner<3, 3>() - count * mean * mean.transpose();
  Eigen::Matrix4d form = scatter;
  form.topLeftCorner<3, 3>() -= Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(central).eigenvalues()[0] * Eigen::Matrix3d::Identity();

  const Eigen::Vector4d floors(floor_angle, floor_angle, floor_angle, floor_distance);
  const Eigen::Matrix4d scaled = floors.asDiagonal() * (form / (sigma_point * sigma_point)) * floors.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(0.5 * (scaled + scaled.transpose()));
  // The least eigenvalue is zero, of the fitted plane itself; three remain.
  const Eigen::Vector3d root = eigen.eigenvalues().tail<3>().cwiseMax(0.0).cwiseMin(1.0).cwiseSqrt();
  const SqrtScatter full = root.asDiagonal() * eigen.eigenvectors().rightCols<3>().transpose() * floors.cwiseInverse().asDiagonal();
  const Eigen::HouseholderQR<SqrtScatter> qr(full);
  return qr.matrixQR().triangularView<Eigen::Upper>();
}

CostPtr make_cost(const PosePlanePoints& factor) { return make_cost(PlaneObservation::of(factor)); }

}  // namespace sgraph
