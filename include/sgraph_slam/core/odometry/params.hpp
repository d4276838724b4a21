#pragma once

#include <string>

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

struct KeyframeParams {
  double distance = 0.75;
  double angle = 0.5;
  double time = 0.0;
  std::string cloud = "scans";

  void describe(ParamVisitor& v) {
    v.field("distance", distance, "m", {0, 100}, "A keyframe is closed when the robot has moved this far since the last.");
    v.field("angle", angle, "rad", {0, 6.3}, "... or turned this far.");
    v.field("time", time, "s", {0, 3600}, "... or when this long has passed and it has moved at all; 0: never by time.");
    v.choice("cloud", cloud, {"scan", "scans"},
             "A keyframe's cloud: its own scan, or all scans since the last keyframe put together with the odometry.");
  }
};

struct OdometryParams {
  std::string source = "vgicp";
  KeyframeParams keyframe;

  void describe(ParamVisitor& v) {
    v.choice("source", source, {"vgicp", "topic"}, "LiDAR odometry of this package, or the robot's odometry.");
    v.group("keyframe", keyframe, "When a keyframe is closed, and what it holds.");
  }
};

}  // namespace sgraph
