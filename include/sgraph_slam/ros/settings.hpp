#pragma once

#include <string>

#include <ros/node_handle.h>

#include "sgraph_slam/core/params/params_io.hpp"
#include "sgraph_slam/core/pipeline/params.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// What only the nodelets need to know.
struct RosSettings {
  std::string base_frame = "base_link";
  std::string odom_frame = "odom";
  std::string map_frame = "map";
  std::string lidar_frame;
  std::string base_to_lidar;
  std::string map_directory = "maps";
  std::string map;
  std::string map_mode = "continue";
  std::string start = "search";
  bool use_imu = false;
  int scan_queue = 10;
  double tf_rate = 20;
  double tf_lookahead = 0.1;
  double map_leaf = 0.1;
  double layer_height = 7;
  double storey_gap = 0;
  int storey = -1;

  void describe(ParamVisitor& v);
};

struct Settings {
  Params params;
  RosSettings ros;
};

/// A parameter tree as values by full name. Throws ParamError for what isn't a scalar.
ParamValues to_values(const XmlRpc::XmlRpcValue& tree);

/// Reads the parameters once, all from `config` beside the nodelets: one tree for all of them, `config/ros` the settings above. Throws ParamError
/// with every error.
Settings load_settings(const ros::NodeHandle& node);

/// "x y z yaw pitch roll" in metres and radians. Throws ParamError.
Pose parse_mount(const std::string& text);

}  // namespace sgraph
