#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/odometry/odometry.hpp"
#include "sgraph_slam/core/pipeline/scan_gate.hpp"
#include "sgraph_slam/core/pipeline/source.hpp"

namespace sgraph {

/// The odometry of one recording: what a sensor set delivers while time runs forward, all clouds from one LiDAR. Not thread-safe.
class Recording {
 public:
  /// Called with each scan when its turn has come, and what it brought.
  using Sink = std::function<void(const CloudPtr& scan, const OdometryOutput& output, double milliseconds)>;

  /// `wait_for_imu`: whether scans wait for the inertial readings of their time.
  Recording(const OdometryParams& params, bool wait_for_imu, const std::string& lidar_frame, const Pose& T_base_lidar, Sink sink);

  void add(SensorEvent event);

  /// Ends the recording: takes the scans that still wait and returns the last keyframes.
  std::vector<Keyframe> finish();

  /// How far back of the newest scan that has had its turn this one is [s]; negative when it is later.
  [[nodiscard]] double goes_back(const Cloud& scan) const { return newest_ ? *newest_ - scan.stamp : -1; }

  [[nodiscard]] const std::string& lidar_frame() const { return lidar_frame_; }
  [[nodiscard]] const Pose& T_base_lidar() const { return T_base_lidar_; }

 private:
  void pass_on();

  std::string lidar_frame_;
  Pose T_base_lidar_;
  Sink sink_;
  Odometry odometry_;
  ScanGate gate_;
  std::optional<Stamp> newest_;  // scan
};

}  // namespace sgraph
