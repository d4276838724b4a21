#include "sgraph_slam/core/pipeline/pipeline.hpp"

#include "sgraph_slam/core/util/stopwatch.hpp"

namespace sgraph {
namespace {

double& of(StageTimes& times, Stage stage) { return times[static_cast<std::size_t>(stage)]; }

}  // namespace

const char* to_string(Stage value) {
  switch (value) {
    case Stage::prefilter: return "prefilter";
    case Stage::odometry: return "odometry";
    case Stage::segmentation: return "segmentation";
    case Stage::mapping: break;
  }
  return "mapping";
}

std::optional<Stage> stage_from(const std::string& word) {
  for (const Stage stage : all_stages) {
    if (word == to_string(stage)) return stage;
  }
  return std::nullopt;
}

Pipeline::Pipeline(const Params& params, const Pose& T_base_lidar, Stage until)
    : until_(until),
      T_base_lidar_(T_base_lidar),
      prefilter_(params.prefilter),
      odometry_(params.odometry, T_base_lidar),
      segmenter_(params.segmentation),
      back_end_(params.mapping, T_base_lidar) {}

const ScanRecord& Pipeline::process(const Cloud& raw) {
  ScanRecord record;
  record.stamp = raw.stamp;
  Stopwatch watch;
  const FilteredScan filtered = prefilter_.process(raw);
  record.counts = filtered.counts;
  of(record.milliseconds, Stage::prefilter) = watch.lap();
  if (until_ >= Stage::odometry) {
    const OdometryOutput output = odometry_.process(filtered.cloud);
    of(record.milliseconds, Stage::odometry) = watch.lap();
    record.verdict = output.verdict;
    record.keyframes = static_cast<int>(output.keyframes.size());
    record.segments = take(output, record.milliseconds);
    if (output.verdict == ScanVerdict::accepted) {
      record.odometry = output.live;
      live_.push_back({raw.stamp, back_end_.snapshot()->T_map_odom * output.live.T_odom_base});
    }
  }
  records_.push_back(std::move(record));
  return records_.back();
}

int Pipeline::take(const OdometryOutput& output, StageTimes& times) {
  finals_.insert(finals_.end(), output.finals.begin(), output.finals.end());
  int planes = 0;
  for (const Keyframe& keyframe : output.keyframes) {
    keyframes_.push_back({keyframe.stamp, keyframe.T_odom_base});
    if (until_ < Stage::segmentation) continue;
    Stopwatch watch;
    const PlaneSegments segments = segmenter_.process(*keyframe.cloud);
    planes += static_cast<int>(segments.segments.size());
    of(times, Stage::segmentation) += watch.lap();
    if (until_ < Stage::mapping) continue;
    note_solve(back_end_.process(keyframe, segments)->last_solve);
    of(times, Stage::mapping) += watch.lap();
  }
  return planes;
}

void Pipeline::finish() {
  if (until_ < Stage::odometry) return;
  Stopwatch watch;
  const OdometryOutput output = odometry_.finish();
  of(finish_milliseconds_, Stage::odometry) = watch.lap();
  take(output, finish_milliseconds_);
  if (until_ < Stage::mapping || keyframes_.empty()) return;
  watch.lap();
  note_solve(back_end_.optimize()->last_solve);
  of(finish_milliseconds_, Stage::mapping) += watch.lap();
}

// A snapshot carries the newest solve whether or not it is new.
void Pipeline::note_solve(const SolveSummary& solve) {
  if (solve.keyframes == 0) return;
  const bool same = !solves_.empty() && solves_.back().milliseconds == solve.milliseconds && solves_.back().factors == solve.factors &&
                    solves_.back().keyframes == solve.keyframes;
  if (!same) solves_.push_back(solve);
}

Trajectory Pipeline::trajectory() const {
  const GraphSnapshotPtr snapshot = back_end_.snapshot();
  Trajectory trajectory = corrected_trajectory(*snapshot);
  // Scans that no keyframe holds yet are as far off as the newest one that does.
  for (const StampedPose& scan : finals_) {
    if (trajectory.empty() || scan.stamp > trajectory.back().stamp) trajectory.push_back({scan.stamp, snapshot->T_map_odom * scan.pose});
  }
  return trajectory;
}

}  // namespace sgraph
