#include "sgraph_slam/ros/tf_clock.hpp"

#include <cmath>

namespace sgraph {

namespace {

/// Odometry that is this close to ROS time runs on it [s]: the rest is the time that a scan takes to come through.
constexpr double same_clock = 2;

ros::Time add(ros::Time time, ros::Duration duration) {
  // ros::Time throws below zero; simulated time starts there.
  const double sum = time.toSec() + duration.toSec();
  return sum > 0 ? time + duration : ros::Time();
}

}  // namespace

void TfClock::heard(ros::Time stamp, ros::Time now) {
  const ros::Duration offset = stamp - now;
  offset_ = std::abs(offset.toSec()) < same_clock ? ros::Duration(0) : offset;
}

std::optional<ros::Time> TfClock::stamp(ros::Time now) {
  if (!offset_) return {};
  const ros::Time stamp = add(add(now, *offset_), lookahead_);
  const bool went_back = now < last_now_;
  last_now_ = now;
  if (stamp == last_stamp_ || (stamp < last_stamp_ && !went_back && last_stamp_ - stamp < ros::Duration(same_clock))) return {};
  last_stamp_ = stamp;
  return stamp;
}

}  // namespace sgraph
