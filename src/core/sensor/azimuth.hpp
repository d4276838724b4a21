#pragma once

#include <cmath>

#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

constexpr double full_turn = 2 * M_PI;  // [rad]

/// An angle in -pi .. pi [rad].
inline double wrapped(double angle) { return std::remainder(angle, full_turn); }

/// Whether a point of a raw cloud is a return: finite, and not at the origin, where drivers put what has none.
inline bool is_return(const Point& p) {
  const double rho = std::hypot(static_cast<double>(p.x), static_cast<double>(p.y));
  return std::isfinite(rho) && std::isfinite(p.z) && rho > 0.05;
}

/// Azimuth of a point, counter-clockwise from x [rad].
inline double azimuth_of(const Point& p) { return std::atan2(static_cast<double>(p.y), static_cast<double>(p.x)); }

}  // namespace sgraph
