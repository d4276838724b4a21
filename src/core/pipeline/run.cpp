#include "sgraph_slam/core/pipeline/run.hpp"

#include "sgraph_slam/core/io/temporary_clouds.hpp"

namespace sgraph {

Run::Run(const MappingParams& params, const Pose& T_base_lidar, Stage until, SessionStart start)
    : until_(until),
      T_base_lidar_(T_base_lidar),
      session_(params, T_base_lidar, until >= Stage::mapping ? std::make_shared<TemporaryClouds>() : nullptr, std::move(start)) {}

const ScanRecord& Run::take(const MeasuredScan& scan) {
  records_.push_back(scan.record);
  map(scan, records_.back().cost);
  if (until_ >= Stage::odometry && scan.odometry.verdict == ScanVerdict::accepted) {
    live_.push_back({scan.record.stamp, session_.snapshot()->T_map_odom * scan.odometry.live.T_odom_base});
  }
  return records_.back();
}

void Run::finish(const MeasuredScan& rest) {
  finish_cost_ = rest.record.cost;
  map(rest, finish_cost_);
  if (until_ < Stage::mapping || keyframes_.empty()) return;
  StageClock clock;
  solves_.note(*session_.optimize());
  clock.book(Stage::mapping, finish_cost_);
}

void Run::map(const MeasuredScan& scan, StageCost& cost) {
  const OdometryOutput& odometry = scan.odometry;
  finals_.insert(finals_.end(), odometry.finals.begin(), odometry.finals.end());
  for (std::size_t i = 0; i < odometry.keyframes.size(); ++i) {
    keyframes_.push_back({odometry.keyframes[i].stamp, odometry.keyframes[i].T_odom_base});
    if (until_ < Stage::mapping) continue;
    StageClock clock;
    solves_.note(*session_.process(odometry.keyframes[i], scan.planes.at(i)));
    note_steps();
    clock.book(Stage::mapping, cost);
  }
}

void Run::note_steps() {
  for (const auto& [step, milliseconds] : session_.steps()) steps_[step].push_back(milliseconds);
}

StageCost Run::total_cost() const {
  StageCost total = finish_cost_;
  for (const ScanRecord& record : records_) total += record.cost;
  return total;
}

Trajectory Run::trajectory() const {
  const GraphSnapshotPtr snapshot = session_.snapshot();
  Trajectory trajectory = corrected_trajectory(*session_.travelled());
  // Scans that no keyframe holds yet are as far off as the newest one that does.
  for (const StampedPose& scan : finals_) {
    if (trajectory.empty() || scan.stamp > trajectory.back().stamp) trajectory.push_back({scan.stamp, snapshot->T_map_odom * scan.pose});
  }
  return trajectory;
}

}  // namespace sgraph
