#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include <ros/node_handle.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_listener.h>

#include "sgraph_slam/core/types/pose.hpp"
#include "sgraph_slam/ros/settings.hpp"

namespace sgraph {

/// Where the sensors are on the robot, from tf. Never waits: what isn't known yet is nothing, not the identity. Thread-safe.
class FixedFrames {
 public:
  FixedFrames(const ros::NodeHandle& node, const RosSettings& settings);

  /// Pose of the LiDAR on the robot: the setting `base_to_lidar` where it is given (it is then published for the others too), else tf's.
  std::optional<Pose> mount(const std::string& lidar_frame);

  /// `T_target_source`, looked up once and remembered.
  std::optional<Pose> lookup(const std::string& target, const std::string& source);

  /// A sentence that names the transform that `mount` or `lookup` didn't find.
  static std::string missing(const std::string& target, const std::string& source);

 private:
  const std::string base_frame_;
  const std::string base_to_lidar_;
  std::mutex mutex_;                                           // guards the next two
  std::map<std::pair<std::string, std::string>, Pose> known_;  // by target and source
  std::optional<tf2_ros::StaticTransformBroadcaster> broadcaster_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_;
};

}  // namespace sgraph
