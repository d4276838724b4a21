#pragma once

#include <string>

#include <ros/node_handle.h>
#include <tf2_ros/transform_broadcaster.h>

#include "sgraph_slam/core/odometry/odometry.hpp"
#include "sgraph_slam/ros/settings.hpp"

namespace sgraph {

/// Tells the world what the odometry found: `odom`, tf, `deskewed_points` and `odometry_status` every scan, `keyframes` and `keyframe_points` every
/// keyframe.
class OdometryPublisher {
 public:
  OdometryPublisher(ros::NodeHandle node, const Settings& settings);

  /// `stamp`: of the scan, also when it was refused.
  void publish(Stamp stamp, const OdometryOutput& output, const Pose& T_base_lidar);
  void publish_keyframes(const std::vector<Keyframe>& keyframes, const Pose& T_base_lidar);

 private:
  const std::string odom_frame_;
  const std::string base_frame_;
  const bool broadcast_;  // false: the robot itself sends odom -> base
  ros::Publisher odom_;
  ros::Publisher deskewed_;
  ros::Publisher status_;
  ros::Publisher keyframes_;
  ros::Publisher keyframe_points_;
  tf2_ros::TransformBroadcaster broadcaster_;
};

}  // namespace sgraph
