#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "sgraph_slam/core/planes/wall.hpp"

namespace sgraph {

/// Walls of a hand-drawn plan. A wall goes from a to b with its free side on the left hand.
struct Plan {
  std::vector<Wall> walls;

  PlaneId add(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const std::vector<Interval>& holes = {}) {
    Wall wall;
    wall.id = {static_cast<std::int64_t>(walls.size())};
    const Eigen::Vector2d along = (b - a).normalized();
    wall.normal = {-along.y(), along.x()};
    wall.offset = -wall.normal.dot(a);
    // direction() is left of the normal: from b to a.
    const double end = wall.direction().dot(a);
    Intervals solid = gaps(unite(holes), {0, (b - a).norm()});
    for (const Interval& part : solid) wall.support.push_back({end - part.high, end - part.low});
    wall.support = unite(wall.support);
    wall.last_seen = {0};
    walls.push_back(wall);
    return wall.id;
  }

  /// Four walls around a rectangle, free side inside, in the order -x, +x, -y, +y; `door`: hole in the -y wall, from its -x end.
  std::vector<PlaneId> box(double x0, double y0, double x1, double y1, const std::vector<Interval>& door = {}) {
    const PlaneId low_y = add({x0, y0}, {x1, y0}, door);
    const PlaneId high_x = add({x1, y0}, {x1, y1});
    const PlaneId high_y = add({x1, y1}, {x0, y1});
    const PlaneId low_x = add({x0, y1}, {x0, y0});
    return {low_x, high_x, low_y, high_y};
  }

  /// The plan turned about the origin and moved.
  [[nodiscard]] std::vector<Wall> moved(double yaw, const Eigen::Vector2d& shift) const {
    std::vector<Wall> turned = walls;
    const Eigen::Rotation2Dd R(yaw);
    for (Wall& wall : turned) {
      wall.normal = R * wall.normal;
      wall.offset -= wall.normal.dot(shift);
      for (Interval& part : wall.support) {
        part.low += wall.direction().dot(shift);
        part.high += wall.direction().dot(shift);
      }
    }
    return turned;
  }
};

}  // namespace sgraph
