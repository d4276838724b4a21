#include "sgraph_slam/core/graph/factors/pose_plane.hpp"

#include <ceres/cost_function.h>

#include "plane_observation.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {

CostPtr make_cost(const PosePlane& factor) {
  Eigen::Matrix<double, 3, 4> tangent = Eigen::Matrix<double, 3, 4>::Zero();
  tangent.topLeftCorner<2, 3>() = tangent_basis(factor.measured.normal).transpose();
  tangent(2, 3) = 1.0;
  return make_plane_observation(factor.weight.matrix() * tangent, factor.weight.matrix().col(2) * factor.measured.d, factor.T_base_lidar);
}

}  // namespace sgraph
