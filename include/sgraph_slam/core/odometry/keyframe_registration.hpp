#pragma once

#include <optional>

#include "sgraph_slam/core/odometry/params.hpp"
#include "sgraph_slam/core/registration/surface_map.hpp"
#include "sgraph_slam/core/types/odometry.hpp"

namespace sgraph {

/// Measures the motion between keyframes whose odometry doesn't say well how the robot moved (wheels, legs: they slip and know nothing of tilt), by
/// aligning each one's scan with what the last ones saw. With an odometry that registers scans itself it has nothing to do and costs nothing.
class KeyframeRegistration {
 public:
  KeyframeRegistration(const KeyframeRegistrationParams& params, const Pose& T_base_lidar) : params_(params), T_base_lidar_(T_base_lidar) {}

  /// The keyframe's motion since the one before, measured as far as its scan holds it: in the directions that it doesn't hold, the odometry's.
  /// Nothing where the odometry is good enough, for the first keyframe, and where too little matches. Keyframes come in order.
  std::optional<KeyframeMotion> measure(const Keyframe& keyframe);

 private:
  std::optional<KeyframeMotion> align(const Cloud& cloud, const KeyframeMotion& claimed);
  void insert(const Cloud& cloud);

  KeyframeRegistrationParams params_;
  Pose T_base_lidar_;
  std::optional<SurfaceMap> map_;
  Pose T_map_base_;                  // of the last keyframe
  std::optional<Pose> T_odom_last_;  // as its odometry says
};

}  // namespace sgraph
