#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Geometry>

#include "mirror_walls.hpp"

namespace sgraph::mirrors {

/// How many rays pass each cell of the space behind the walls, of those that end well behind it: what stands there lets them through, or is an image.
class RayPasses {
 public:
  /// Counts within these bounds; empty ones: nowhere.
  explicit RayPasses(const Eigen::AlignedBox3d& bounds);
  /// Counts the ray behind the wall, but for its end: what it only grazes is not passed.
  void add(const Sight& sight, const Wall& wall);
  /// Whether so many rays pass a point that it isn't an edge which a few slip past.
  [[nodiscard]] bool enough_at(const Eigen::Vector3d& p) const;

 private:
  static constexpr int border = 1;  // around what is asked for [cells]

  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  double cell_ = 0;  // [m]
  std::vector<std::uint8_t> count_;
};

}  // namespace sgraph::mirrors
