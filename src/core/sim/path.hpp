#pragma once

#include <vector>

#include "sgraph_slam/core/sim/world.hpp"

namespace sgraph::sim {

/// Where the robot is on the floor at one moment.
struct PlanarState {
  double time = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double heading = 0;  ///< unwrapped [rad]
  double z = 0;        ///< of the floor [m]
};

/// The route driven within the profile's limits, at moments at most a few hundredths of a second apart while it moves. Throws WorldError.
std::vector<PlanarState> drive_route(const Route& route, const MotionProfile& profile);

}  // namespace sgraph::sim
