#include "sgraph_slam/ros/fixed_frames.hpp"

#include <geometry_msgs/TransformStamped.h>

#include "sgraph_slam/ros/conversions.hpp"
#include "sgraph_slam/ros/messages.hpp"

namespace sgraph {

FixedFrames::FixedFrames(const ros::NodeHandle& node, const RosSettings& settings)
    : base_frame_(settings.base_frame),
      base_to_lidar_(settings.base_to_lidar),
      buffer_(ros::Duration(tf2::BufferCore::DEFAULT_CACHE_TIME)),
      listener_(buffer_, node, true) {}

std::optional<Pose> FixedFrames::mount(const std::string& lidar_frame) {
  if (base_to_lidar_.empty()) return lookup(base_frame_, lidar_frame);
  const Pose pose = parse_mount(base_to_lidar_);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!broadcaster_ && lidar_frame != base_frame_) {
    broadcaster_.emplace();
    geometry_msgs::TransformStamped message;
    message.header.stamp = ros::Time::now();
    message.header.frame_id = base_frame_;
    message.child_frame_id = lidar_frame;
    message.transform = to_transform(pose);
    broadcaster_->sendTransform(message);
  }
  return pose;
}

std::optional<Pose> FixedFrames::lookup(const std::string& target, const std::string& source) {
  if (target == source) return Pose();
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto known = known_.find({target, source});
  if (known != known_.end()) return known->second;
  try {
    const Converted<Pose> pose = to_pose(buffer_.lookupTransform(target, source, ros::Time(0)).transform);
    if (!pose) return {};
    known_[{target, source}] = pose.value;
    return pose.value;
  } catch (const tf2::TransformException&) {
    return {};
  }
}

std::string FixedFrames::missing(const std::string& target, const std::string& source) {
  return "no transform from '" + source + "' to '" + target + "' on tf: publish it as a static transform, or give base_to_lidar";
}

}  // namespace sgraph
