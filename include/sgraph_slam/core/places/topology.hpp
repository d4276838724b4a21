#pragma once

#include <string>
#include <vector>

#include "sgraph_slam/core/places/polygon.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// A place on the ground.
struct Place {
  std::string name;  ///< "room/3", "corridor/0"
  Polygon2d outline;
};

/// Where the robot has walked from one place into another: these places touch there. `path`: positions in order, map frame. Walking through a third,
/// unknown space of more than `max_way` [m] on the way shows nothing. Crossings of the same two places less than `same` [m] apart are one opening,
/// midway of them.
std::vector<SceneOpening> find_openings(const std::vector<Place>& places, const std::vector<Eigen::Vector3d>& path, double max_way = 1.5,
                                        double same = 1.0);

}  // namespace sgraph
