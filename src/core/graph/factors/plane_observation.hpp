#pragma once

#include <Eigen/Core>

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/graph/factors/pose_plane.hpp"
#include "sgraph_slam/core/graph/factors/pose_plane_points.hpp"

namespace sgraph {

/// What the forms of the pose-plane factor share: the residual is linear in the plane as the robot sees it,
///
///   e = A pi_base - b,  pi_base = [R^T n ; d + t . n],  T_map_base = (R, t)
///
/// with the extrinsic taken into A. Most factors of a graph are of this kind, so the solver knows them by this form.
struct PlaneObservation {
  Eigen::Matrix<double, 3, 4> A;
  Eigen::Vector3d b;

  /// `e = A pi_lidar - b`, moved to the base frame.
  static PlaneObservation in_lidar(const Eigen::Matrix<double, 3, 4>& A, const Eigen::Vector3d& b, const Pose& T_base_lidar);
  static PlaneObservation of(const PosePlane& factor);
  static PlaneObservation of(const PosePlanePoints& factor);

  using ByPose = Eigen::Matrix<double, 3, 6>;

  /// The residual, and its Jacobians unless they are null. `basis`: tangent_basis(normal).
  void evaluate(const Eigen::Matrix3d& R, const Eigen::Vector3d& t, const Eigen::Vector3d& normal, double d, const Eigen::Matrix<double, 3, 2>& basis,
                Eigen::Vector3d& e, ByPose* by_pose, Eigen::Matrix3d* by_plane) const {
    const Eigen::Vector3d n_base = R.transpose() * normal;
    const auto by_n = A.leftCols<3>();
    const auto by_d = A.col(3);
    e = by_n * n_base + by_d * (d + t.dot(normal)) - b;
    if (by_pose != nullptr) {  // R exp(phi): n_base + n_base x phi; t + R rho
      for (int r = 0; r < 3; ++r) by_pose->template leftCols<3>().row(r) = by_n.row(r).cross(n_base.transpose());
      by_pose->template rightCols<3>().noalias() = by_d * n_base.transpose();
    }
    if (by_plane != nullptr) {
      by_plane->leftCols<2>().noalias() = by_n * (R.transpose() * basis) + by_d * (t.transpose() * basis);
      by_plane->col(2) = by_d;
    }
  }
};

CostPtr make_cost(const PlaneObservation& observation);

}  // namespace sgraph
