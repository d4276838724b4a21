#pragma once

#include <memory>
#include <vector>

#include "sgraph_slam/core/odometry/params.hpp"
#include "sgraph_slam/core/odometry/surface_residual.hpp"
#include "sgraph_slam/core/sensor/ring_calibration.hpp"
#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/sensor.hpp"

namespace sgraph {

/// Why a scan was taken or refused.
enum class ScanVerdict {
  accepted,
  too_few_points,  ///< nothing to register
  not_later,       ///< its stamp isn't after the last one's: a repeated message or clocks that jump back
  stamp_jumped,    ///< its stamp is far ahead of those of the scans after it
  no_odometry,     ///< `source: topic`, and the robot's odometry doesn't cover the scan
};

const char* to_string(ScanVerdict value);

/// What one scan brings. With a refused scan only `verdict` counts.
struct OdometryOutput {
  ScanVerdict verdict = ScanVerdict::accepted;
  OdometryEstimate live;                               ///< this scan's pose, at once
  CloudPtr deskewed;                                   ///< this scan as seen from the LiDAR's live pose at the stamp; never null when accepted
  Trajectory finals;                                   ///< final poses that became known with this scan (of the scan before), in order
  std::vector<Keyframe> keyframes;                     ///< closed with this scan, in order; usually none or one
  std::shared_ptr<const RingCalibration> calibration;  ///< of the LiDAR's beams, as it is after this scan
};

/// Second stage: the only place that owns motion. Estimates the motion within and between scans (design: odometry study), keeps the local
/// map and chooses keyframes. Not thread-safe: one caller.
class Odometry {
 public:
  /// `T_base_lidar`: pose of the LiDAR on the robot.
  Odometry(const OdometryParams& params, const Pose& T_base_lidar);
  ~Odometry();
  Odometry(Odometry&&) noexcept;
  Odometry& operator=(Odometry&&) noexcept;

  /// Robot odometry and inertial readings up to a scan's end must come before that scan.
  void add(const OdometrySample& sample);
  void add(const ImuSample& sample);

  /// Hands over the residuals of accepted scans from now on, for a calibration of the sensor. Costs nothing while nobody asks.
  void observe_residuals(ResidualSink sink);

  /// Takes a prefiltered scan in the LiDAR's frame, in order of stamp.
  OdometryOutput process(const CloudPtr& scan);

  /// Ends the recording: final poses and the last keyframe of what is still in the window. `live` and `deskewed` stay empty.
  OdometryOutput finish();

  /// What is known of the LiDAR's beams. Never null.
  [[nodiscard]] std::shared_ptr<const RingCalibration> calibration() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sgraph
