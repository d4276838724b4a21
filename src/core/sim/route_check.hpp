#pragma once

#include "sgraph_slam/core/sim/motion.hpp"
#include "sgraph_slam/core/sim/world.hpp"

namespace sgraph::sim {

/// Throws WorldError, with the place, when the robot would pass through a wall, a window, a column, furniture or a person, or leave the building,
/// or a person would walk through any of these,
/// or a piece of furniture sticks in a wall.
void check_routes(const World& world, const Motion& motion);

/// The same of a building with its errors built in, 5 cm more lenient: what they move was checked as planned. Furniture is not looked at.
void check_routes_as_built(const World& world);

/// Whether a piece of furniture (`Block::piece`) stands clear of the storey's walls, columns and other furniture.
bool furniture_fits(const Storey& storey, int piece);

}  // namespace sgraph::sim
