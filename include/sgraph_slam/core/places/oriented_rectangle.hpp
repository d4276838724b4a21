#pragma once

#include <Eigen/Core>

namespace sgraph {

enum Side { low_x = 0, high_x = 1, low_y = 2, high_y = 3 };  ///< of a rectangle, in its own axes

/// A rectangle on the map's ground.
struct OrientedRectangle {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d size = Eigen::Vector2d::Zero();  ///< along its own x and y [m]
  double yaw = 0;

  [[nodiscard]] bool contains(const Eigen::Vector2d& p, double margin = 0) const;
  [[nodiscard]] double area() const { return size.x() * size.y(); }
};

/// Area that two rectangles share [m^2].
double shared_area(const OrientedRectangle& a, const OrientedRectangle& b);

}  // namespace sgraph
