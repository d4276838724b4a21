#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/ids.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// How a scan's motion was found.
enum class OdometryStatus {
  started,    ///< first scan, or first after a restart: the pose is the prediction
  tracked,    ///< registered against the local map
  predicted,  ///< too little matched, or the result was refused as a jump: the prediction is kept
  external,   ///< taken from another odometry source
};

const char* to_string(OdometryStatus value);

/// Where the robot is at one scan's stamp, as known when that scan has been processed.
struct OdometryEstimate {
  Stamp stamp;
  Pose T_odom_base;
  Matrix6 covariance = Matrix6::Zero();  ///< of the pose, order rotation [rad^2], translation [m^2], right perturbation (base frame)
  Vector6 twist = Vector6::Zero();       ///< angular [rad/s] and linear [m/s] velocity at the stamp, in the base frame
  OdometryStatus status = OdometryStatus::started;
  double inlier_share = 0;  ///< share of the keypoints that found the map
  double residual_rms = 0;  ///< of the matched keypoints along the normals [m]
  int keypoints = 0;
  int iterations = 0;
  std::vector<Vector6> degenerate;  ///< unit directions (rotation, translation; base frame) that the data doesn't hold
};

/// A motion between two keyframes and its covariance (rotation [rad^2], translation [m^2]; right perturbation).
struct KeyframeMotion {
  Pose T_last_now;
  Matrix6 covariance;
};

/// How far a lift has carried the robot: from floor to floor.
struct Rise {
  double height = 0;  ///< upwards [m]
  double sigma = 0;   ///< standard deviation [m]
};

/// Of a ride of which nothing tells how far it went.
constexpr Rise unknown_rise{0, 10.0};

/// A pose worth remembering, closed when its pose is final; every scan belongs to exactly one keyframe.
struct Keyframe {
  KeyframeId id;
  Stamp stamp;
  Pose T_odom_base;                          ///< final pose at the stamp
  Matrix6 covariance = Matrix6::Identity();  ///< of the motion since the last keyframe; rotation, translation; right perturbation
  std::vector<Vector6> degenerate;           ///< unit directions of that motion that the data doesn't hold
  std::optional<KeyframeMotion> measured;    ///< that motion as its scan holds it, where the odometry says too little of it (wheels, legs)
  std::optional<Rise> ride;                  ///< a lift carried the robot since the last keyframe; the poses in odom don't have that
  Trajectory scans;                          ///< final base poses in odom of the scans since the last keyframe, this one's last
  CloudPtr cloud;                            ///< in the LiDAR's frame at the stamp, motion taken out
};

}  // namespace sgraph
