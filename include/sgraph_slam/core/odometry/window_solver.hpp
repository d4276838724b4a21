#pragma once

#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/odometry/motion.hpp"
#include "sgraph_slam/core/odometry/motion_sensors.hpp"
#include "sgraph_slam/core/registration/surface_map.hpp"

namespace sgraph {

/// A point to register: where the sensor saw it, and when.
struct Keypoint {
  Eigen::Vector3d p_lidar;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< of the scan's own surface there, LiDAR frame; zero when unknown or not asked for
  int segment = 0;                                   ///< the knots `segment` and `segment + 1` lie around it
  double fraction = 0;                               ///< 0 at the first of them, 1 at the second
  bool newest = true;                                ///< of the newest scan, by which the result is judged
};

/// How much the velocity may change from one segment to the next.
struct VelocityPrior {
  static constexpr double step = 0.05;                   ///< [s] that the sigmas are given for
  double rotation_sigma = 0;                             ///< change of the rotation over a step [rad]
  double translation_sigma = 0;                          ///< change of the way over a step [m]
  Eigen::Vector3d rotated = Eigen::Vector3d::Zero();     ///< standard deviation along a direction, beside these [rad, odom's axes]
  Eigen::Vector3d translated = Eigen::Vector3d::Zero();  ///< likewise of the way [m]
};

/// Another sensor's measurement of the motion along a segment.
struct SegmentMeasurement {
  int segment = 0;  ///< from the knot `segment` to the next
  MeasuredMotion measured;
};

struct WindowProblem {
  Knots knots;                       ///< in: predicted, out: solved
  int first_free = 0;                ///< knots before this one are held
  std::vector<VelocityPrior> prior;  ///< a knot; held at the knots 1 .. size - 2, between the segments before and after, in the sensor's axes
  std::vector<Keypoint> keypoints;
  std::vector<Matrix6>
      observable;  ///< a segment: projection of its knots' steps onto the directions that its points hold; the others are the prior's
  std::vector<SegmentMeasurement> measurements;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< in odom; a sway along it dies away where the points don't tell the height
};

struct WindowOptions {
  int iterations = 8;
  double kernel = 0.06;        ///< scale of the robust kernel at the end [m]
  double noise = 0.02;         ///< standard deviation of a residual [m]
  double patch_effect = 1;     ///< how many times more variance the points leave than if they were independent (core/math/noise.hpp)
  double start_scale = 3.0;    ///< the kernel begins this much wider
  bool distributions = false;  ///< residual between two Gaussians instead of along the surface's normal (VGICP, Koide et al. 2021)
  double gate_scale = 3.0;     ///< points farther than this many kernels from a surface don't match
  bool plumb = false;          ///< walls count as plumb (`plumb`)
  bool oblique = true;         ///< then what is neither wall nor floor (the underside of a flight of stairs) counts as it is; otherwise not at all
};

struct WindowResult {
  double inlier_share = 0;  ///< of the newest scan's keypoints within the kernel
  double agreement = 0;     ///< of those that came near a surface of the map: within the kernel
  double residual_rms = 0;  ///< of those [m]
  int iterations = 0;
  bool converged = false;
  /// Of the free knots with the prior: (rotation, translation) a knot, left perturbation in odom. Points count with the rms of the newest scan's
  /// inliers and the patch effect.
  Eigen::MatrixXd information;
};

/// Finds the knots' poses together from points on surfaces, other sensors' measurements of the motion and the prior on the change of velocity:
/// Gauss-Newton with step control (design: odometry study, section 1). Perturbation of a knot: `R <- exp(phi) R`, `t <- t + v`, in odom's axes.
WindowResult solve_window(const SurfaceMap& map, WindowProblem& problem, const WindowOptions& options);

}  // namespace sgraph
