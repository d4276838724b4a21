#pragma once

#include <optional>
#include <vector>

#include "sgraph_slam/core/odometry/params.hpp"
#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/odometry.hpp"

namespace sgraph {

/// One scan whose pose will not change any more.
struct FinalScan {
  Stamp stamp;
  Pose T_odom_base;
  Matrix6 covariance = Matrix6::Zero();  ///< of the registration against the local map, base frame
  std::vector<Vector6> degenerate;       ///< directions that it didn't hold, base frame
  CloudPtr cloud;                        ///< LiDAR frame, motion taken out
  bool accepted = true;                  ///< false: the pose is only a prediction
  std::optional<Rise> ride = {};         ///< a lift has carried the robot since the scan before
};

/// Standard deviation of a ride's tilt [rad]: a cabin's walls, without floor and ceiling, hold it to a degree or two.
constexpr double carried_tilt = 0.035;

/// What an odometry adds to the uncertainty of a motion by the way that it takes; standard deviations.
struct DriftRate {
  double rotation;     ///< [rad/m]
  double turning;      ///< [rad/rad]
  double translation;  ///< [m/m]
};

constexpr DriftRate map_drift{0.0005, 0, 0.003};  ///< of a pose held by a local map

/// Decides by motion and time which scans become keyframes and gives every scan to exactly one. What it holds of the scans since the last keyframe is
/// bounded by the area that they see, and one pose a scan.
class KeyframeSelector {
 public:
  KeyframeSelector(const KeyframeParams& params, const Pose& T_base_lidar, const DriftRate& drift = map_drift)
      : params_(params), T_base_lidar_(T_base_lidar), drift_(drift) {}

  /// Takes the next final scan; returns the keyframe that it closes, if any. The first scan is always one; a scan whose pose is only a prediction
  /// closes none, and its points are in none.
  std::optional<Keyframe> add(const FinalScan& scan);

  /// Closes the last keyframe with the scans that are left, if any.
  std::optional<Keyframe> finish();

  /// Points held of the scans since the last keyframe.
  [[nodiscard]] std::size_t held_points() const;

 private:
  // A scan's cloud, or several put together: then with viewpoints, in the frame of the newest of them.
  struct Part {
    Stamp stamp;
    Pose T_odom_lidar;
    CloudPtr cloud;
  };

  void hold(const FinalScan& scan);
  void hold_directions(const std::vector<Vector6>& directions);
  Keyframe close();
  [[nodiscard]] CloudPtr keyframe_cloud() const;
  static CloudPtr merged(const std::vector<Part>& parts, const Part& frame, double leaf);

  KeyframeParams params_;
  Pose T_base_lidar_;
  DriftRate drift_;
  std::int64_t next_id_ = 0;
  std::optional<FinalScan> previous_;  // the last keyframe's scan, without its cloud
  std::optional<FinalScan> newest_;    // since then
  Trajectory scans_;                   // since then,
  std::vector<Vector6> degenerate_;    // the directions that the accepted ones' points didn't hold,
  std::vector<Part> parts_;            // and the clouds of these, in order
  double path_ = 0;                    // travelled since then [m]
  double turned_ = 0;                  // [rad]
  std::optional<Rise> ride_;           // in a lift since then
};

}  // namespace sgraph
