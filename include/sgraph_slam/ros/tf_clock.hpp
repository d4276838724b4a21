#pragma once

#include <optional>

#include <ros/time.h>

namespace sgraph {

/// Dates the transform from map to odom, which is sent at a steady rate whether or not something new is known.
///
/// The stamp is the present, `lookahead` into the future: tf interpolates between stamps, so a consumer that asks for the pose at any moment up to
/// now finds it without waiting for the next transform (amcl's `transform_tolerance` does the same). A correction therefore shows after `lookahead`
/// at the latest. The present is ROS time, unless the odometry's stamps say that the data runs on another clock (a bag played without --clock, a
/// sensor that counts from its start): then it is the newest odometry stamp, moved on by the time since it came, or map and odom would have no moment
/// in common.
class TfClock {
 public:
  explicit TfClock(ros::Duration lookahead) : lookahead_(lookahead) {}

  /// An odometry message with this stamp came at `now`.
  void heard(ros::Time stamp, ros::Time now);

  /// The stamp for a transform sent at `now`; nothing before the first odometry, or when it would repeat the last one.
  std::optional<ros::Time> stamp(ros::Time now);

 private:
  ros::Duration lookahead_;
  std::optional<ros::Duration> offset_;  // from ROS time to the data's clock
  ros::Time last_now_;
  ros::Time last_stamp_;
};

}  // namespace sgraph
