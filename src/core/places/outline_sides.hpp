#pragma once

#include <cmath>
#include <vector>

#include "sgraph_slam/core/places/find_places.hpp"

namespace sgraph {

constexpr double right_angle = 0.1745;  // sides off the right angle, or off parallel, by up to this make a rectangle [rad]
constexpr double one_line = 0.12;       // sides no further apart are of one line [m]

inline Eigen::Vector2d left_of(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }
inline double yaw_of(const Eigen::Vector2d& v) { return std::atan2(v.y(), v.x()); }

/// A side of an outline.
struct SideLine {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
  Eigen::Vector2d direction;  ///< unit; the place is to its left
  double length = 0;          ///< [m]
  PlaceSide side;
};

/// The sides of a polygon; `side` is empty.
std::vector<SideLine> sides_of(const Polygon2d& polygon);

/// Those of an outline, then those of its holes.
std::vector<SideLine> all_sides(const PlaceOutline& outline);

/// The wall with an id, or null.
const Wall* find_wall(const std::vector<Wall>& walls, PlaneId id);

/// Distance between two facing walls, and where its middle lies.
struct Across {
  double width;   ///< [m]
  double middle;  ///< along the axis [m]
};

/// Between two walls that face each other along an axis, measured beside a point.
Across between(const Wall& low, const Wall& high, const Eigen::Vector2d& axis, const Eigen::Vector2d& near);

/// Turns a corridor around when it does not head within (-45, 135] degrees of the reference.
void head_as_reference(FoundPlace& corridor, double reference_yaw);

}  // namespace sgraph
