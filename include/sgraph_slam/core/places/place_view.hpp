#pragma once

#include <array>
#include <vector>

#include "sgraph_slam/core/planes/wall.hpp"

namespace sgraph {

/// A wall across an axis of a place.
struct Face {
  std::size_t wall = 0;  ///< index among the walls
  double position = 0;   ///< along the axis that it bounds [m]
  Intervals span;        ///< where it has been seen, along the other axis [m]
  double trust = 0;      ///< of the wall, for its views, 0..1
  double height = 0;     ///< of what has been seen of the wall [m]
};

/// A wall along neither axis, by its ends in the place's coordinates.
struct ObliqueWall {
  std::size_t wall = 0;
  Eigen::Vector2d from = Eigen::Vector2d::Zero();
  Eigen::Vector2d to = Eigen::Vector2d::Zero();
};

enum Side { low_x = 0, high_x = 1, low_y = 2, high_y = 3 };  ///< of a place, in its own axes

/// The walls around a position in a frame of a given yaw: sorted by the side of a place that they would bound. Coordinates are along the frame's
/// axes, from the map's origin.
struct PlaceView {
  double yaw = 0;
  Eigen::Vector2d x_axis = Eigen::Vector2d::UnitX();
  Eigen::Vector2d y_axis = Eigen::Vector2d::UnitY();
  std::array<std::vector<Face>, 4> faces;  ///< by Side: their normals point into the place
  std::vector<ObliqueWall> oblique;

  [[nodiscard]] Eigen::Vector2d to_place(const Eigen::Vector2d& p_map) const { return {x_axis.dot(p_map), y_axis.dot(p_map)}; }
  [[nodiscard]] Eigen::Vector2d to_map(const Eigen::Vector2d& p_place) const { return p_place.x() * x_axis + p_place.y() * y_axis; }
};

/// The walls within `reach` [m] of a position as a place of this yaw would have them; a wall more than `parallel` [rad] off both axes is oblique.
PlaceView view_from(const std::vector<Wall>& walls, const Eigen::Vector2d& position_map, double yaw, double reach, double parallel);

/// Directions (modulo 90 degrees) in which walls near a position run, the one with most wall first; at most `count`.
std::vector<double> local_yaws(const std::vector<Wall>& walls, const Eigen::Vector2d& position_map, double reach, double parallel, std::size_t count);

/// Rectangle in a place's coordinates.
struct Rectangle {
  Interval x;
  Interval y;
};

/// Share of a side that wall covers, 0..1: faces of the same side no more than `coplanar` [m] behind the position `at` and no more than `inside` [m]
/// in front of it (what stands before a wall hides it).
double side_coverage(const std::vector<Face>& same_side, bool low, double at, Interval within, double coplanar, double inside);

/// Where the faces of a side within `coplanar` [m] of a position have been seen.
Intervals coplanar_span(const std::vector<Face>& same_side, double at, double coplanar, double gap);

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
