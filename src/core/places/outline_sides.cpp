#include "outline_sides.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sgraph {

std::vector<SideLine> sides_of(const Polygon2d& polygon) {
  std::vector<SideLine> sides;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    SideLine side{polygon[i], polygon[(i + 1) % polygon.size()], Eigen::Vector2d::UnitX(), 0, {}};
    side.length = (side.to - side.from).norm();
    if (side.length > 1e-9) side.direction = (side.to - side.from) / side.length;
    sides.push_back(side);
  }
  return sides;
}

std::vector<SideLine> all_sides(const PlaceOutline& outline) {
  std::vector<SideLine> all;
  const auto add = [&](const PlaceLoop& loop) {
    std::vector<SideLine> sides = sides_of(loop.polygon);
    for (std::size_t i = 0; i < sides.size(); ++i) {
      sides[i].side = loop.sides[i];
      all.push_back(sides[i]);
    }
  };
  add(outline);
  for (const PlaceLoop& hole : outline.holes) add(hole);
  return all;
}

const Wall* find_wall(const std::vector<Wall>& walls, PlaneId id) {
  const auto found = std::find_if(walls.begin(), walls.end(), [&](const Wall& wall) { return wall.id == id; });
  return found == walls.end() ? nullptr : &*found;
}

Across between(const Wall& low, const Wall& high, const Eigen::Vector2d& axis, const Eigen::Vector2d& near) {
  const auto crossing = [&](const Wall& wall) { return axis.dot(near) - wall.distance(near) / wall.normal.dot(axis); };
  const double a = crossing(low);
  const double b = crossing(high);
  return {b - a, 0.5 * (a + b)};
}

void head_as_reference(FoundPlace& corridor, double reference_yaw) {
  const double turned = std::remainder(corridor.area.yaw - reference_yaw - M_PI / 4, 2 * M_PI);  // in (-90, 90] for headings within (-45, 135]
  if (turned > -M_PI / 2 && turned <= M_PI / 2) return;
  std::swap(corridor.walls[0], corridor.walls[1]);
  corridor.area.yaw = std::remainder(corridor.area.yaw + M_PI, 2 * M_PI);
}

}  // namespace sgraph
