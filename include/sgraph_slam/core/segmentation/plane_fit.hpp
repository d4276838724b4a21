#pragma once

#include <Eigen/Core>

#include "sgraph_slam/core/types/plane.hpp"

namespace sgraph {

/// Total least squares plane of points given by their scatter, the sum of [p; 1][p; 1]^T.
struct PlaneFit {
  Plane plane;  ///< of either sign
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  Eigen::Vector3d spread = Eigen::Vector3d::Zero();  ///< standard deviations along the normal, the shorter and the longer direction on the plane [m]
  Eigen::Vector3d long_axis = Eigen::Vector3d::UnitX();  ///< unit vector of the longer direction
  bool valid = false;                                    ///< false with fewer than three points, or points on a line
};

PlaneFit fit_plane(const Eigen::Matrix4d& scatter);

/// Mean squared distance of the scatter's points from a plane [m^2].
double mean_squared_distance(const Eigen::Matrix4d& scatter, const Plane& plane);

/// Covariance of [two tangent angles in tangent_basis(normal); d] of a least-squares plane whose points have the standard deviation `sigma` [m]
/// along the normal: sigma^2 (J^T S J)^-1 with J = diag(tangent_basis(normal), 1). The points must not lie on a line.
Eigen::Matrix3d plane_covariance(const Plane& plane, const Eigen::Matrix4d& scatter, double sigma);

}  // namespace sgraph
