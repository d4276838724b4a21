#pragma once

#include <Eigen/Core>

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/types/ids.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// The inliers of one plane in one scan, reduced to what their distances to any plane need: upper trapezoidal, 3 x 4, with
/// `|sqrt_scatter [n; d]|^2 = sum over the points of ((n . p + d) / sigma)^2, less its least value over all planes`. The constant part (how rough the
/// wall is) is taken away, which moves no minimum and lets chi-square and robust losses see the misfit alone.
using SqrtScatter = Eigen::Matrix<double, 3, 4>;

/// `scatter`: sum of [p; 1][p; 1]^T over the inliers, LiDAR frame. `sigma_point`: standard deviation of a point's distance [m]. The information is
/// bounded to what `floor_angle` [rad] and `floor_distance` [m], standard deviations of the plane's normal and distance at the LiDAR, allow in any
/// direction: errors that all points of a scan share (its pose, its motion, the calibration) don't average out. Non-finite input gives a non-finite
/// result.
SqrtScatter sqrt_scatter(const Eigen::Matrix4d& scatter, double sigma_point, double floor_angle, double floor_distance);

/// A plane observed from a keyframe, as the inliers themselves (points form, plane adjustment).
///
///   pi_L = T_ML^T pi_M = [ R_ML^T n_M ; d_M + t_ML . n_M ],  T_ML = T_map_base T_base_lidar
///   e = sqrt_scatter pi_L,  3 residuals in standard deviations
///
/// Blocks: keyframe, plane. Nothing is assumed about directions the points don't hold (a wall seen as one stripe). Doesn't tell the two sides of the
/// plane apart. Source: design: Planes, points form (plane adjustment; BALM and eigen-factors are relatives).
struct PosePlanePoints {
  KeyframeId keyframe;
  PlaneId plane;
  SqrtScatter points = SqrtScatter::Zero();  ///< LiDAR frame
  Pose T_base_lidar;                         ///< constant extrinsic

  static constexpr const char* type = "pose_plane_points";
  static constexpr int residuals = 3;
  static constexpr int rank = 3;

  template <class Self, class Visitor>
  static void describe(Self& f, Visitor& v) {
    v.block("keyframe", f.keyframe);
    v.block("plane", f.plane);
    v.field("sqrt_scatter", f.points);
    v.field("base_lidar", f.T_base_lidar);
  }
};

CostPtr make_cost(const PosePlanePoints& factor);

}  // namespace sgraph
