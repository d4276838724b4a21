#pragma once

#include <vector>

#include "sgraph_slam/core/pipeline/params.hpp"
#include "sgraph_slam/core/pipeline/stage.hpp"
#include "sgraph_slam/core/segmentation/plane_segmenter.hpp"

namespace sgraph {

/// What the stages before the mapping make of one scan, or of the recording's end. A value: several back ends may take the same one.
struct MeasuredScan {
  ScanRecord record;
  OdometryOutput odometry;
  std::vector<PlaneSegments> planes;  ///< seen in the clouds of `odometry.keyframes`, in their order; empty before the segmentation
};

/// Prefilter and odometry: everything that looks at each scan.
class FrontEnd {
 public:
  /// Stops after the prefilter when `until` says so. Throws what the stages' constructors throw at bad parameters.
  FrontEnd(const Params& params, const Pose& T_base_lidar, Stage until = Stage::mapping);

  void add(const OdometrySample& sample) { odometry_.add(sample); }
  void add(const ImuSample& sample) { odometry_.add(sample); }

  /// Takes a raw scan in the LiDAR's frame, in order of stamp.
  MeasuredScan process(const Cloud& raw);
  /// Ends the recording: what the odometry still held.
  MeasuredScan finish();

  /// What is known of the LiDAR's beams. Never null.
  [[nodiscard]] std::shared_ptr<const RingCalibration> calibration() const { return odometry_.calibration(); }

 private:
  bool registers_;
  Prefilter prefilter_;
  Odometry odometry_;
};

/// Finds the planes of the scan's keyframes.
void segment(const PlaneSegmenter& segmenter, MeasuredScan& scan);

}  // namespace sgraph
