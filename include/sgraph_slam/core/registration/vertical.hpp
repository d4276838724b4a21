#pragma once

#include <optional>

#include <Eigen/Core>

#include "sgraph_slam/core/registration/surface_map.hpp"

namespace sgraph {

/// The building's vertical in the map's frame, within about 25 degrees of `guess`: what its floors and ceilings have for their normal and what its
/// walls contain. None when there are too few surfaces, or only walls of one direction.
std::optional<Eigen::Vector3d> vertical_of(const SurfaceMap& map, const Eigen::Vector3d& guess);

}  // namespace sgraph
