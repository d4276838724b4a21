#pragma once

#include <functional>

#include <ros/node_handle.h>
#include <sgraph_slam/LoadMap.h>
#include <sgraph_slam/SaveMap.h>
#include <std_srvs/Trigger.h>

#include "sgraph_slam/core/types/pose.hpp"
#include "sgraph_slam/ros/back_end_thread.hpp"
#include "sgraph_slam/ros/map_publisher.hpp"
#include "sgraph_slam/ros/settings.hpp"

namespace sgraph {

/// The services `save`, `load`, `pause`, `resume`, `reset` and `optimize`. Paths are taken inside the configured map directory. Each answers within a
/// minute, with success or with a sentence that says what is wrong.
class MapServices {
 public:
  /// `live`: the poses as they were published while the robot went.
  MapServices(ros::NodeHandle node, const Settings& settings, BackEndThread& back_end, MapPublisher& publisher, std::function<Trajectory()> live);

 private:
  bool save(sgraph_slam::SaveMap::Request& request, sgraph_slam::SaveMap::Response& response);
  bool load(sgraph_slam::LoadMap::Request& request, sgraph_slam::LoadMap::Response& response);
  bool pause(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool resume(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool reset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool optimize(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  const Settings settings_;
  BackEndThread& back_end_;
  MapPublisher& publisher_;
  const std::function<Trajectory()> live_;
  ros::ServiceServer save_;
  ros::ServiceServer load_;
  ros::ServiceServer reset_;
  ros::ServiceServer pause_;
  ros::ServiceServer resume_;
  ros::ServiceServer optimize_;
};

}  // namespace sgraph
