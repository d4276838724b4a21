#pragma once

#include <vector>

#include "sgraph_slam/core/odometry/keyframe_selector.hpp"
#include "sgraph_slam/core/odometry/odometry.hpp"
#include "sgraph_slam/core/odometry/surface_residual.hpp"
#include "sgraph_slam/core/sensor/ring_calibration.hpp"

namespace sgraph {

/// What one scan brings from where motion is found.
struct MotionOutput {
  ScanVerdict verdict = ScanVerdict::accepted;
  OdometryEstimate live;
  CloudPtr deskewed;
  std::vector<FinalScan> finals;  ///< scans that became final, in order
};

/// Finds the motion of scans: by registration, or from the robot's odometry.
class MotionSource {
 public:
  virtual ~MotionSource() = default;
  virtual void add(const OdometrySample& sample) = 0;
  virtual void add(const ImuSample& sample) = 0;
  virtual MotionOutput process(const CloudPtr& scan) = 0;
  /// From now on; a source that registers nothing never calls it.
  virtual void observe_residuals(ResidualSink) {}  // NOLINT(performance-unnecessary-value-param): kept by those that override it
  /// Scans are remembered from now on, so that `correct` reaches them too; or, as at the beginning, they aren't.
  virtual void remember_scans(bool /*remember*/) {}
  /// The scans that have come still have what this takes out.
  virtual void correct(const RingCalibration& /*added*/) {}
  /// The scans that are not final yet.
  virtual std::vector<FinalScan> finish() = 0;
};

}  // namespace sgraph
