#pragma once

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

/// What carries the LiDAR can do. The defaults hold for robots on wheels or legs and for people who walk.
struct RobotParams {
  double speed = 3.0;
  double turn_rate = 4.0;
  double climb_rate = 0.5;
  double step = 0.15;
  double tilt = 0.4;
  double tilt_rate = 1.0;
  double acceleration = 1.0;
  double angular_acceleration = 3.0;
  double odometry_scale = 0.03;
  double odometry_turning = 0.02;
  double odometry_heading = 0.005;

  void describe(ParamVisitor& v) {
    v.field("speed", speed, "m/s", {0.1, 50}, "Fastest; a registration that would need more is taken for a wrong one.");
    v.field("turn_rate", turn_rate, "rad/s", {0.1, 20}, "Fastest turn, likewise.");
    v.field("climb_rate", climb_rate, "m/s", {0.01, 10}, "Fastest change of height, likewise; stairs are climbed at about 0.3.");
    v.field("step", step, "m", {0, 1}, "Change of height that may come at once: a kerb, a stair, a jolt.");
    v.field("tilt", tilt, "rad", {0.05, 3.2}, "Largest change of tilt while no scan is accepted.");
    v.field("tilt_rate", tilt_rate, "rad/s", {0.01, 20}, "Fastest change of tilt.");
    v.field("acceleration", acceleration, "m/s^2", {0.01, 100}, "Usual acceleration, by which a predicted motion goes wrong.");
    v.field("angular_acceleration", angular_acceleration, "rad/s^2", {0.01, 100}, "... and of turns.");
    v.field("odometry_scale", odometry_scale, "m/m", {0, 1}, "Standard deviation of the robot's own odometry a metre of way: scale and slips.");
    v.field("odometry_turning", odometry_turning, "rad/rad", {0, 1}, "... of its turns, a radian.");
    v.field("odometry_heading", odometry_heading, "rad/m", {0, 1}, "... of its heading a metre of way.");
  }
};

}  // namespace sgraph
