#pragma once

#include "sgraph_slam/core/sim/motion.hpp"
#include "sgraph_slam/core/sim/world.hpp"

namespace sgraph::sim {

/// Throws WorldError, with the place, when the robot would pass through a wall, a window, a column, furniture or a person, or leave the building,
/// or a person would walk through any of these,
/// or a piece of furniture sticks in a wall.
void check_routes(const World& world, const Motion& motion);

}  // namespace sgraph::sim
