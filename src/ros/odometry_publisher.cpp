#include "sgraph_slam/ros/odometry_publisher.hpp"

#include <geometry_msgs/TransformStamped.h>

#include "sgraph_slam/ros/cloud_message.hpp"
#include "sgraph_slam/ros/messages.hpp"
#include "sgraph_slam/ros/shared_pointer.hpp"

namespace sgraph {

OdometryPublisher::OdometryPublisher(ros::NodeHandle node, const Settings& settings)
    : odom_frame_(settings.ros.odom_frame),
      base_frame_(settings.ros.base_frame),
      broadcast_(settings.params.odometry.source != "topic"),
      odom_(node.advertise<nav_msgs::Odometry>("odom", 100)),
      deskewed_(node.advertise<Cloud>("deskewed_points", 10)),
      status_(node.advertise<sgraph_slam::OdometryStatus>("odometry_status", 100)),
      // What these carry must not be lost on the way to a slow reader.
      keyframes_(node.advertise<sgraph_slam::Keyframe>("keyframes", 1000)),
      keyframe_points_(node.advertise<Cloud>("keyframe_points", 1000)) {}

void OdometryPublisher::publish(Stamp stamp, const OdometryOutput& output, const Pose& T_base_lidar) {
  OdometryEstimate estimate = output.live;
  estimate.stamp = stamp;
  status_.publish(to_status_message(output.verdict, estimate, odom_frame_));
  if (output.verdict != ScanVerdict::accepted) return;
  const nav_msgs::Odometry odom = to_odometry_message(output.live, odom_frame_, base_frame_);
  if (broadcast_) {
    geometry_msgs::TransformStamped transform;
    transform.header = odom.header;
    transform.child_frame_id = base_frame_;
    transform.transform = to_transform(output.live.T_odom_base);
    broadcaster_.sendTransform(transform);
  }
  odom_.publish(odom);
  deskewed_.publish(to_boost(output.deskewed));
  publish_keyframes(output.keyframes, T_base_lidar);
}

void OdometryPublisher::publish_keyframes(const std::vector<Keyframe>& keyframes, const Pose& T_base_lidar) {
  for (const Keyframe& keyframe : keyframes) {
    keyframes_.publish(to_message(keyframe, T_base_lidar, odom_frame_, base_frame_));
    keyframe_points_.publish(to_boost(keyframe.cloud));
  }
}

}  // namespace sgraph
