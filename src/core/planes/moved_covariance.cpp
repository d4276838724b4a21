#include "sgraph_slam/core/planes/moved_covariance.hpp"

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {

Eigen::Matrix3d moved_covariance(const Pose& T_target_source, const Plane& in_source, const Plane& in_target, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix<double, 3, 2> turned = T_target_source.matrix() * tangent_basis(in_source.normal);
  Eigen::Matrix3d by_source = Eigen::Matrix3d::Identity();
  by_source.topLeftCorner<2, 2>() = tangent_basis(in_target.normal).transpose() * turned;
  by_source.bottomLeftCorner<1, 2>() = -T_target_source.translation.transpose() * turned;
  return by_source * covariance * by_source.transpose();
}

}  // namespace sgraph
