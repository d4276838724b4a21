#pragma once

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/graph/sqrt_information.hpp"
#include "sgraph_slam/core/types/ids.hpp"
#include "sgraph_slam/core/types/plane.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// A plane observed from a keyframe, as a fitted plane (tangent form).
///
///   n_L = R_ML^T n_M,  d_L = d_M + t_ML . n_M,  T_ML = T_map_base T_base_lidar
///   e = W [ B(n_hat)^T n_L ; d_L - d_hat ],  3 residuals: two tangent angles [rad], distance [m], LiDAR frame; B = tangent_basis
///
/// Blocks: keyframe, plane. To first order azimuth (times cos elevation), elevation and distance of the paper, without their poles at floors and
/// ceilings. Degenerate when the normals are 90 degrees apart or more: the sine of the angle falls again, so a plane seen from behind must not be
/// associated (association gates on n . n_hat). Source: paper, Metric-Semantic Layer; design: Planes.
struct PosePlane {
  KeyframeId keyframe;
  PlaneId plane;
  Plane measured;             ///< LiDAR frame, normal towards the LiDAR
  Pose T_base_lidar;          ///< constant extrinsic
  SqrtInformation<3> weight;  ///< of [two angles in tangent_basis(measured.normal); d]

  static constexpr const char* type = "pose_plane";
  static constexpr int residuals = 3;
  static constexpr int rank = 3;

  template <class Self, class Visitor>
  static void describe(Self& f, Visitor& v) {
    v.block("keyframe", f.keyframe);
    v.block("plane", f.plane);
    v.field("measured", f.measured);
    v.field("base_lidar", f.T_base_lidar);
    v.field("sqrt_information", f.weight);
  }
};

CostPtr make_cost(const PosePlane& factor);

}  // namespace sgraph
