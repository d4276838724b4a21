#pragma once

#include <string>

#include "sgraph_slam/core/odometry/ring_calibrator.hpp"
#include "sgraph_slam/core/odometry/robot_params.hpp"
#include "sgraph_slam/core/params/visitor.hpp"
#include "sgraph_slam/core/registration/surface_map.hpp"

namespace sgraph {

struct KeyframeParams {
  double distance = 0.75;
  double angle = 0.5;
  double time = 0.0;
  std::string cloud = "auto";
  double leaf = 0.05;

  void describe(ParamVisitor& v) {
    v.field("distance", distance, "m", {0.01, 100}, "A keyframe is closed when the robot has moved this far since the last.");
    v.field("angle", angle, "rad", {0.01, 6.3}, "... or turned this far.");
    v.field("time", time, "s", {0, 3600}, "... or when this long has passed; 0: never by time.");
    v.choice("cloud", cloud, {"auto", "scan", "scans"},
             "A keyframe's cloud: its own scan, or all scans since the last keyframe put together with their final poses. auto: scans with LiDAR "
             "odometry; its own where the motion is known too poorly to put scans together: with the robot's, which knows nothing of tilt, and where "
             "the motion within a scan isn't found.");
    v.field("leaf", leaf, "m", {0, 1}, "Voxels of which one point each is kept when scans are put together; 0: all points.");
  }
};

/// Motion within and between scans; design: odometry study, section 1.
struct MotionParams {
  std::string model = "window";
  std::string residual = "normal";
  int segments = 2;
  double rotation_sigma = 0.0009;
  double translation_sigma = 0.0015;
  int iterations = 8;
  double kernel = 0.06;
  double keypoint_leaf = 0.2;
  double min_inliers = 0.1;

  void describe(ParamVisitor& v) {
    v.choice(
        "model", model, {"window", "scan", "velocity", "none"},
        "How the motion within a scan is found. window: solved together with the last scan's; scan: solved for each scan alone, its begin held at "
        "the last one's end; velocity: taken out beforehand with the last scan's velocity, then one pose a scan, that of its middle; none: not at "
        "all, likewise. All but the first are less accurate and here for comparison.");
    v.choice("residual", residual, {"normal", "distribution"},
             "normal: a point's distance along its surface's normal; distribution: between the Gaussians of the surface and of the point's own "
             "neighbourhood in the scan, both flattened to planes (VGICP), for comparison.");
    v.field("segments", segments, "", {1, 4}, "Pieces of constant velocity within a scan. More than two may each see one wall only.");
    v.field("rotation_sigma", rotation_sigma, "rad", {1e-6, 1},
            "Prior on the change of velocity: of the rotation over 50 ms. Widened by itself when the sensor is moved briskly.");
    v.field("translation_sigma", translation_sigma, "m", {1e-6, 1}, "... of the way over 50 ms.");
    v.field("iterations", iterations, "", {1, 100}, "Most steps of the solver on the two newest scans.");
    v.field("kernel", kernel, "m", {0.005, 1}, "Scale of the robust kernel, at least three times the noise that the map shows.");
    v.field("keypoint_leaf", keypoint_leaf, "m", {0, 5}, "One point in a voxel of this edge is registered; 0: all.");
    v.field("min_inliers", min_inliers, "", {0, 1}, "Below this share of matched points the prediction is kept.");
  }
};

/// Motions between keyframes measured by their scans, where the odometry is poor.
struct KeyframeRegistrationParams {
  bool enabled = true;
  double min_sigma = 0.01;
  double leaf = 0.2;
  double min_inliers = 0.3;

  void describe(ParamVisitor& v) {
    v.field("enabled", enabled, "Measure the motion between keyframes by their scans where the odometry is poor.");
    v.field("min_sigma", min_sigma, "rad", {0, 1},
            "Poor means: the standard deviation of the rotation between keyframes, tilt included, is at least this; of wheels it is always.");
    v.field("leaf", leaf, "m", {0.05, 2}, "One point in a voxel of this edge is registered.");
    v.field("min_inliers", min_inliers, "", {0, 1}, "Below this share of matched points the odometry is believed.");
  }
};

struct OdometryParams {
  std::string source = "vgicp";
  SurfaceMapParams map;
  double map_leaf = 0.1;
  MotionParams motion;
  KeyframeParams keyframe;
  KeyframeRegistrationParams registration;
  CalibrationParams calibration;
  RobotParams robot;  ///< a group of its own, not described here

  void describe(ParamVisitor& v) {
    v.choice("source", source, {"vgicp", "topic"}, "LiDAR odometry of this package, or the robot's odometry.");
    v.group("map", map, "The local map: Gaussians in voxels.");
    v.field("map_leaf", map_leaf, "m", {0, 5}, "One point in a voxel of this edge of each scan enters the map; 0: all.");
    v.group("motion", motion, "Motion within the scan, solved together with the pose.");
    v.group("keyframe", keyframe, "When a keyframe is closed, and what it holds.");
    v.group("registration", registration, "Motions between keyframes where the odometry is poor.");
    v.group("calibration", calibration, "Errors of the LiDAR's beams (docs/sensors.md).");
  }
};

}  // namespace sgraph
