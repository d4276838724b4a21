#pragma once

#include <functional>

#include "sgraph_slam/core/pipeline/batches.hpp"
#include "sgraph_slam/core/pipeline/front_end.hpp"
#include "sgraph_slam/core/pipeline/run.hpp"

namespace sgraph {

/// The four stages in order: the offline program and the tests. The nodelets run the same stage objects. To compare parameters on one recording see
/// VariantSet.
class Pipeline {
 public:
  /// Runs the stages up to and including `until`. Throws what the stages' constructors throw at bad parameters.
  Pipeline(const Params& params, const Pose& T_base_lidar, Stage until = Stage::mapping, SessionStart start = {})
      : front_end_(params, T_base_lidar, until), segmenter_(params.segmentation), run_(params.mapping, T_base_lidar, until, std::move(start)) {}

  /// Shows the map to an observer as it grows (see BackEnd).
  void observe(MapObserver* observer) { run_.observe(observer); }

  void add(const OdometrySample& sample) { front_end_.add(sample); }
  void add(const ImuSample& sample) { front_end_.add(sample); }

  /// Takes a raw scan in the LiDAR's frame, in order of stamp. The record stays valid until the next call.
  const ScanRecord& process(const Cloud& raw) { return run_.take(segmented(front_end_.process(raw))); }

  /// Takes a whole recording, the stages beside each other on TBB's threads: while one scan is mapped those after it are registered. Each stage
  /// takes the scans in order, so the result is that of process(), whatever the number of threads. `done` is called after each scan has been mapped.
  /// Throws what the stages throw; what reading throws comes after all that was read has been mapped.
  void process_all(NextEvent next, const std::function<void(const ScanRecord&)>& done);

  /// Ends the recording: closes the last keyframe and optimises once more.
  void finish() { run_.finish(segmented(front_end_.finish())); }

  /// What is known of the LiDAR's beams. Never null.
  [[nodiscard]] std::shared_ptr<const RingCalibration> calibration() const { return front_end_.calibration(); }
  /// What came of it so far.
  [[nodiscard]] const Run& run() const { return run_; }

 private:
  MeasuredScan segmented(MeasuredScan scan) const {
    if (run_.until() >= Stage::segmentation) segment(segmenter_, scan);
    return scan;
  }

  FrontEnd front_end_;
  PlaneSegmenter segmenter_;
  Run run_;
};

}  // namespace sgraph
