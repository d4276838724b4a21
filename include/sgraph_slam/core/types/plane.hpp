#pragma once

#include <Eigen/Core>

#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// The plane of all x with `normal . x + d = 0`, `|normal| = 1` (design of the S-Graph: one convention everywhere).
/// The normal points into the free space that the surface was seen from; the two faces of a wall are two planes.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double d = 0;  ///< [m]; in the LiDAR's frame positive, in the map of any sign

  /// Signed distance of a point [m], positive on the free side.
  [[nodiscard]] double distance(const Eigen::Vector3d& p) const { return normal.dot(p) + d; }
};

/// The same plane in frame a, given in frame b: `n_a = R n_b`, `d_a = d_b - t . n_a`.
inline Plane operator*(const Pose& T_a_b, const Plane& plane_b) {
  const Eigen::Vector3d n = T_a_b.rotation * plane_b.normal;
  return {n, plane_b.d - T_a_b.translation.dot(n)};
}

/// By the tilt of the normal; x and y among the vertical ones are those of the building's dominant frame.
enum class PlaneClass { x, y, horizontal, unclassified };

const char* to_string(PlaneClass value);

}  // namespace sgraph
