#pragma once

#include <vector>

#include "sgraph_slam/core/places/place_view.hpp"
#include "sgraph_slam/core/planes/wall.hpp"

namespace sgraph {

/// How far a wall's figures are to be trusted for the number of its views, 0..1.
double trust(const Wall& wall);

/// Of the planes that lie in the side of a place which `present` bounds (facing as it does within `parallel` [rad], no more than `coplanar` [m] off
/// it in the middle of the side), the furthest out among those that show most wall along it, weighted with their trust: a wall rather than the
/// cupboards' fronts, the shelves' backs or the piece behind a door that were seen first. `present` stays unless another is clearly better.
PlaneId dominant_wall(const std::vector<Wall>& walls, PlaneId present, const OrientedRectangle& place, double coplanar, double parallel);

}  // namespace sgraph
