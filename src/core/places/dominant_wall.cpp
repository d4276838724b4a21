#include "sgraph_slam/core/places/dominant_wall.hpp"

#include <algorithm>
#include <cmath>

namespace sgraph {
namespace {

constexpr double known_well = 10;       // views
constexpr double comparable = 0.8;      // share of the greatest weight
constexpr double behind = 0.01;         // [m]
constexpr double corner_margin = 0.05;  // what reaches round the place's corner isn't of this side [m]

// The place's side along a direction.
Interval side_along(const OrientedRectangle& place, const Eigen::Vector2d& direction) {
  const Eigen::Vector2d x(std::cos(place.yaw), std::sin(place.yaw));
  const double along_x = std::abs(direction.dot(x));
  const double half = 0.5 * (along_x > M_SQRT1_2 ? place.size.x() : place.size.y()) - corner_margin;
  const double center = direction.dot(place.center);
  return {center - half, center + half};
}

}  // namespace

double trust(const Wall& wall) {
  const auto views = static_cast<double>(wall.views);
  return (1 + views) / (known_well + views);
}

PlaneId dominant_wall(const std::vector<Wall>& walls, PlaneId present, const OrientedRectangle& place, double coplanar, double parallel) {
  const auto own = std::find_if(walls.begin(), walls.end(), [&](const Wall& wall) { return wall.id == present; });
  if (own == walls.end()) return present;
  const Interval side = side_along(place, own->direction());
  const Eigen::Vector2d middle = own->at(side.center());
  const auto weight = [&](const Wall& wall) { return total_length(clip(wall.support, side_along(place, wall.direction()))) * trust(wall); };
  std::vector<const Wall*> same_side;
  double most = 0;
  for (const Wall& wall : walls) {
    if (wall.normal.dot(own->normal) < std::cos(parallel) || std::abs(wall.distance(middle)) > coplanar) continue;
    same_side.push_back(&wall);
    most = std::max(most, weight(wall));
  }
  // Things stand before a wall and not behind it.
  PlaneId best;
  double furthest = 0;
  for (const Wall* wall : same_side) {
    const double depth = wall->distance(middle) + (wall->id == present ? behind : 0);
    if (weight(*wall) < comparable * most || (best.valid() && depth <= furthest)) continue;
    furthest = depth;
    best = wall->id;
  }
  return best;
}

}  // namespace sgraph
