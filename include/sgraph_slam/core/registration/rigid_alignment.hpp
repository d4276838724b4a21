#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/registration/surface_map.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// A point in the map's frame as predicted, and where the sensor was when it saw it.
struct SeenPoint {
  Eigen::Vector3d point;
  Eigen::Vector3d sensor;
};

struct RigidAlignmentOptions {
  int iterations = 6;
  double kernel_begin = 0.5;   ///< scale of the robust kernel at the first step [m]
  double kernel_end = 0.1;     ///< ... and at the last, geometrically between
  double noise = 0.02;         ///< standard deviation of a residual [m]
  double held_sigma = 0.02;    ///< only directions known better than this move [m, rotation counted at `arm`]
  double normal_sigma = 0.03;  ///< error of the map's normals that must not pass for information [rad]
  double arm = 5.0;            ///< [m]
  Reach reach = Reach::wide;
  /// Unit vertical, where walls alone hold the sensor: they count as plumb (`plumb`), it is moved on the ground alone, and nothing holds its height.
  std::optional<Eigen::Vector3d> plumb_along;
  Pose start;  ///< correction to begin with
};

struct RigidAlignmentResult {
  Pose correction;          ///< moves the predicted points onto the map: `p_map = correction * p_predicted`
  double inlier_share = 0;  ///< of the points within the last kernel
  double support = 0;       ///< the same weighed over directions: geometric mean of the eigenvalues of the inliers' sum of n n^T, a point
  double rotation = 0;      ///< size of the correction [rad]
  double translation = 0;   ///< movement of the sensor [m],
  Eigen::Vector3d moved = Eigen::Vector3d::Zero();  ///< in the map's axes
  int held_directions = 6;                          ///< of 6, at the last step
  Matrix6 held = Matrix6::Identity();    ///< projection of a step (rotation about the sensor, translation; map's axes) onto the held directions
  std::vector<Vector6> free_directions;  ///< unit directions (rotation, translation; map's axes about the sensor) that the data doesn't hold
};

/// Aligns a scan as one rigid body: wide kernel narrowing over a few Gauss-Newton steps, moving only in the directions that the data holds; the rest
/// stays with the prediction (design: odometry study, section 1).
RigidAlignmentResult align_rigidly(const SurfaceMap& map, const std::vector<SeenPoint>& points, const RigidAlignmentOptions& options);

/// Unit eigenvectors of an information matrix (rotation, translation), with rotation counted at `arm`, whose standard deviation exceeds `sigma`;
/// `held`, when given, gets the projection of a step onto the others.
std::vector<Vector6> weak_directions(const Matrix6& information, double arm, double sigma, Matrix6* held = nullptr);

}  // namespace sgraph
