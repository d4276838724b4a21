#include "sgraph_slam/ros/recording.hpp"

#include "sgraph_slam/core/util/stopwatch.hpp"

namespace sgraph {

Recording::Recording(const OdometryParams& params, bool wait_for_imu, const std::string& lidar_frame, const Pose& T_base_lidar, Sink sink)
    : lidar_frame_(lidar_frame),
      T_base_lidar_(T_base_lidar),
      sink_(std::move(sink)),
      odometry_(params, T_base_lidar),
      gate_(params.source == "topic", wait_for_imu) {}

void Recording::add(SensorEvent event) {
  gate_.push(std::move(event));
  pass_on();
}

std::vector<Keyframe> Recording::finish() {
  gate_.close();
  pass_on();
  return odometry_.finish().keyframes;
}

void Recording::pass_on() {
  while (const std::optional<CloudPtr> scan = gate_.take_dropped()) {
    OdometryOutput refused;
    refused.verdict = ScanVerdict::stamp_jumped;
    sink_(*scan, refused, 0);
  }
  while (const std::optional<SensorEvent> event = gate_.pop()) {
    if (const auto* sample = std::get_if<OdometrySample>(&*event)) odometry_.add(*sample);
    if (const auto* sample = std::get_if<ImuSample>(&*event)) odometry_.add(*sample);
    if (const auto* scan = std::get_if<CloudPtr>(&*event)) {
      if (!newest_ || (*scan)->stamp > *newest_) newest_ = (*scan)->stamp;
      Stopwatch watch;
      const OdometryOutput output = odometry_.process(*scan);
      sink_(*scan, output, watch.lap());
    }
  }
}

}  // namespace sgraph
