#include "sgraph_slam/core/odometry/external_odometry.hpp"

#include <algorithm>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/odometry/motion.hpp"

namespace sgraph {
namespace {

constexpr double history = 5.0;    // [s] of samples kept
constexpr double tolerance = 0.1;  // [s] beyond the newest sample that its motion is believed to go on

// What a pose's error has that neither grows with the way nor goes away: tilt and height, of which wheels know nothing. Heading and position drift:
// their covariance tells little of one step, so the keyframe's comes from the way.
Matrix6 lasting_error(const Matrix6& covariance) {
  constexpr double tilt = 0.01;    // at least [rad]
  constexpr double height = 0.01;  // [m]
  Matrix6 lasting = Matrix6::Zero();
  for (const int axis : {0, 1}) lasting(axis, axis) = std::max(covariance(axis, axis), tilt * tilt);
  lasting(5, 5) = std::max(covariance(5, 5), height * height);
  return lasting;
}

}  // namespace

void ExternalOdometry::add(const OdometrySample& sample) {
  if (!samples_.empty() && sample.stamp <= samples_.back().stamp) return;
  samples_.push_back(sample);
  while (samples_.back().stamp - samples_.front().stamp > history) samples_.pop_front();
}

MotionOutput ExternalOdometry::process(const CloudPtr& scan) {
  MotionOutput output;
  if (scan->empty()) {
    output.verdict = ScanVerdict::too_few_points;
    return output;
  }
  if (last_stamp_ && scan->stamp <= *last_stamp_) {
    output.verdict = ScanVerdict::not_later;
    return output;
  }
  const TimeSpan firing = firing_times(*scan);
  const Stamp begin = scan->stamp.after(std::min(0.0, firing.begin));
  const Stamp end = scan->stamp.after(std::max(0.0, firing.end));
  if (samples_.size() < 2 || begin < samples_.front().stamp.after(-tolerance) || end > samples_.back().stamp.after(tolerance)) {
    output.verdict = ScanVerdict::no_odometry;
    return output;
  }
  last_stamp_ = scan->stamp;
  Knots lidar;
  for (const OdometrySample& s : samples_) lidar.push_back({s.stamp - scan->stamp, s.T_odom_base * T_base_lidar_});
  const Pose T_odom_base = pose_at(lidar, 0) * T_base_lidar_.inverse();
  const auto i = static_cast<std::size_t>(locate(lidar, 0).segment);

  output.live.stamp = scan->stamp;
  output.live.T_odom_base = T_odom_base;
  output.live.covariance = samples_[i + 1].covariance;
  output.live.twist = se3_log(samples_[i].T_odom_base.inverse() * samples_[i + 1].T_odom_base) / (samples_[i + 1].stamp - samples_[i].stamp);
  output.live.status = OdometryStatus::external;
  output.deskewed = deskew(*scan, 0, lidar);
  output.finals.push_back({scan->stamp, T_odom_base, lasting_error(samples_[i].covariance), {}, output.deskewed});
  return output;
}

}  // namespace sgraph
