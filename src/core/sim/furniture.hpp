#pragma once

#include <string>
#include <vector>

#include "sgraph_slam/core/sim/world.hpp"

namespace sgraph::sim {

/// The boxes that a piece of furniture consists of; empty when no piece has this name. `position` is the middle of its footprint on the floor (world
/// z), its front looks along its own -y, `size` scales the piece to other outer measures (zero components: its own).
std::vector<Block> furniture_piece(const std::string& kind, const Eigen::Vector3d& position, double yaw, const Eigen::Vector3d& size);

/// Names of all pieces, for messages.
std::string furniture_names();

}  // namespace sgraph::sim
