#pragma once

#include <cmath>

#include "sgraph_slam/core/graph/variables.hpp"

namespace sgraph {

/// Finite, and unit length where that is asked for (to 1e-6: values read from text).
inline bool valid(const Pose& pose) {
  return pose.rotation.coeffs().allFinite() && pose.translation.allFinite() && std::abs(pose.rotation.norm() - 1.0) < 1e-6;
}
inline bool valid(const Plane& plane) { return plane.normal.allFinite() && std::isfinite(plane.d) && std::abs(plane.normal.norm() - 1.0) < 1e-6; }
inline bool valid(const Room& room) {
  return std::isfinite(room.yaw) && std::isfinite(room.z) && room.position.allFinite() && room.width.allFinite();
}
inline bool valid(const Corridor& c) {
  return std::isfinite(c.yaw) && std::isfinite(c.along) && std::isfinite(c.z) && std::isfinite(c.position) && std::isfinite(c.width);
}

/// Equal to the bit.
inline bool same(const Pose& a, const Pose& b) { return a.rotation.coeffs() == b.rotation.coeffs() && a.translation == b.translation; }
inline bool same(const Plane& a, const Plane& b) { return a.normal == b.normal && a.d == b.d; }
inline bool same(const Room& a, const Room& b) { return a == b; }
inline bool same(const Corridor& a, const Corridor& b) { return a == b; }

}  // namespace sgraph
