#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/planes/intervals.hpp"
#include "sgraph_slam/core/types/ids.hpp"
#include "sgraph_slam/core/types/plane.hpp"

namespace sgraph {

/// A vertical plane as the detectors see it: a line on the ground, map frame, with the stretches of it where wall has been seen.
struct Wall {
  PlaneId id;
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  ///< unit, into the free space
  double offset = 0;                                  ///< `normal . p + offset = 0` [m], at the wall's mean height
  Intervals support;                                  ///< along `direction()`, from the foot of the map's origin [m]
  double height = 0;                                  ///< from its lowest to its highest seen point [m]
  KeyframeId last_seen;                               ///< newest keyframe that saw it
  std::size_t views = 0;                              ///< keyframes that saw it

  /// Unit vector along the wall, to the left of the normal.
  [[nodiscard]] Eigen::Vector2d direction() const { return {-normal.y(), normal.x()}; }
  /// Point of the line at a position along it.
  [[nodiscard]] Eigen::Vector2d at(double along) const { return along * direction() - offset * normal; }
  [[nodiscard]] double distance(const Eigen::Vector2d& p) const { return normal.dot(p) + offset; }
  /// From its first to its last seen point [m].
  [[nodiscard]] double length() const { return hull(support).length(); }
};

/// The wall of a plane and the outlines (map frame) of what has been seen of it. Nothing for a plane that is no wall (tilted by more than `tilt`
/// [rad] from the vertical) or without outlines. Stretches less than `gap` [m] apart count as one.
std::optional<Wall> make_wall(PlaneId id, const Plane& plane, const std::vector<std::vector<Eigen::Vector3d>>& outlines, double tilt, double gap);

/// Two walls with opposed normals.
struct FacingPair {
  Eigen::Vector2d axis = Eigen::Vector2d::UnitX();  ///< mean normal of the first wall's side: `axis ~ n1 ~ -n2`
  double s1 = 0;                                    ///< positions of the walls along the axis, midway of their common stretch [m]
  double s2 = 0;
  double width = 0;  ///< s2 - s1 [m]: positive when their free sides look at each other, minus the thickness for the two faces of a wall
  Interval common;   ///< stretch that both hulls share, along the axis turned left [m]; reversed when they share none
};

/// Nothing unless the normals are opposed to within `parallel` [rad] (design: Rooms and corridors).
std::optional<FacingPair> facing_pair(const Wall& first, const Wall& second, double parallel);

}  // namespace sgraph
