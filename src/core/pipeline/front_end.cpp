#include "sgraph_slam/core/pipeline/front_end.hpp"

namespace sgraph {

FrontEnd::FrontEnd(const Params& params, const Pose& T_base_lidar, Stage until)
    : registers_(until >= Stage::odometry), prefilter_(params.prefilter), odometry_(params.odometry, T_base_lidar) {}

MeasuredScan FrontEnd::process(const Cloud& raw) {
  MeasuredScan scan;
  scan.record.stamp = raw.stamp;
  StageClock clock;
  const FilteredScan filtered = prefilter_.process(raw);
  clock.book(Stage::prefilter, scan.record.cost);
  scan.record.counts = filtered.counts;
  if (!registers_) return scan;
  scan.odometry = odometry_.process(filtered.cloud);
  clock.book(Stage::odometry, scan.record.cost);
  scan.record.verdict = scan.odometry.verdict;
  scan.record.keyframes = static_cast<int>(scan.odometry.keyframes.size());
  if (scan.odometry.verdict == ScanVerdict::accepted) {
    const OdometryEstimate& live = scan.odometry.live;
    scan.record.motion = {live.status, static_cast<float>(live.inlier_share), static_cast<float>(live.residual_rms), live.iterations,
                          !live.degenerate.empty()};
  }
  return scan;
}

MeasuredScan FrontEnd::finish() {
  MeasuredScan rest;
  if (!registers_) return rest;
  StageClock clock;
  rest.odometry = odometry_.finish();
  clock.book(Stage::odometry, rest.record.cost);
  return rest;
}

void segment(const PlaneSegmenter& segmenter, MeasuredScan& scan) {
  for (const Keyframe& keyframe : scan.odometry.keyframes) {
    StageClock clock;
    scan.planes.push_back(segmenter.process(*keyframe.cloud));
    clock.book(Stage::segmentation, scan.record.cost);
    scan.record.segments += static_cast<int>(scan.planes.back().segments.size());
  }
}

}  // namespace sgraph
