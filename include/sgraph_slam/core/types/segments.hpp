#pragma once

#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/types/plane.hpp"
#include "sgraph_slam/core/types/stamp.hpp"

namespace sgraph {

/// One planar surface seen from one keyframe, in the LiDAR's frame at the keyframe's stamp.
struct PlaneSegment {
  Plane plane;  ///< normal to where it was seen from: d > 0 but for faces that the LiDAR has passed since
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< of [two tangent angles in tangent_basis(normal); d]: rad^2, rad m, m^2
  Eigen::Matrix4d scatter = Eigen::Matrix4d::Zero();         ///< sum of [p; 1][p; 1]^T over the inliers [m^2, m, 1]
  double sigma = 0;                                          ///< rms of the inliers' distances to the plane [m]
  int count = 0;                                             ///< number of inliers
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> extent;  ///< convex outline of the inliers on the plane, counter-clockwise about the normal
};

struct PlaneSegments {
  Stamp stamp;
  std::vector<PlaneSegment> segments;
};

}  // namespace sgraph
