#pragma once

#include <optional>

#include "sgraph_slam/core/mapping/params.hpp"
#include "sgraph_slam/core/registration/surface_map.hpp"
#include "sgraph_slam/core/types/odometry.hpp"

namespace sgraph {

/// A motion between two keyframes and its covariance (rotation, translation; right perturbation).
struct KeyframeMotion {
  Pose T_last_now;
  Matrix6 covariance;
};

/// What the last keyframes saw, for keyframes whose odometry doesn't say well how the robot moved (wheels, legs): their motion is measured against
/// it. With an odometry that registers scans itself it has nothing to do and costs nothing.
class Submap {
 public:
  Submap(const SubmapParams& params, const Pose& T_base_lidar) : params_(params), T_base_lidar_(T_base_lidar) {}

  /// Takes the next keyframe with the motion that its odometry claims. Returns the motion to believe: the measured one where it was needed and the
  /// submap held it, as far as it held it; the claimed one otherwise.
  KeyframeMotion add(const Keyframe& keyframe, const KeyframeMotion& claimed);

 private:
  void insert(const Cloud& cloud);

  SubmapParams params_;
  Pose T_base_lidar_;
  std::optional<SurfaceMap> map_;
  Pose T_submap_base_;  // of the last keyframe
};

}  // namespace sgraph
