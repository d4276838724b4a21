#pragma once

#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/planes/wall.hpp"

namespace sgraph {

/// Takes out of the wall's support where the path (map frame, on the ground, straight between its points) leads through it, with the scraps that are
/// left beside: what has been seen there is a door's leaf that was opened, a lintel, or what segmentation made of several surfaces in one plane. Of a
/// wall that isn't there at all nothing is left.
void open_passages(Wall& wall, const std::vector<Eigen::Vector2d>& path);

}  // namespace sgraph
