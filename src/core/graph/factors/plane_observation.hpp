#pragma once

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// What the forms of the pose-plane factor share: `e = A pi_L - b`, with `pi_L = [R_ML^T n ; d + t_ML . n]` the plane in the LiDAR frame. Blocks:
/// keyframe, plane.
CostPtr make_plane_observation(const Eigen::Matrix<double, 3, 4>& A, const Eigen::Vector3d& b, const Pose& T_base_lidar);

}  // namespace sgraph
