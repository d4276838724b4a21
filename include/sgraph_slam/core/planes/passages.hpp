#pragma once

#include "sgraph_slam/core/planes/ground_path.hpp"
#include "sgraph_slam/core/planes/wall.hpp"

namespace sgraph {

/// Takes out of the wall's support where the path leads through it, with the scraps that are
/// left beside: what has been seen there is a door's leaf that was opened, a lintel, or what segmentation made of several surfaces in one plane. Of a
/// wall that isn't there at all nothing is left.
void open_passages(Wall& wall, const GroundPath& path);

}  // namespace sgraph
