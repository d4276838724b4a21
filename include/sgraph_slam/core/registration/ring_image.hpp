#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// A spinning LiDAR's scan by beam and azimuth. Far from the sensor the rings lie metres apart on a floor or a ceiling, and what a small
/// neighbourhood holds of it is one stripe, a line; the rings below and above show which way the surface leans there.
class RingImage {
 public:
  /// Keeps no reference to the cloud. Rings are put in order by their elevation, whatever their numbers; a cloud without ring numbers gives no
  /// normals.
  explicit RingImage(const Cloud& scan);

  /// Unit normal, towards the sensor, of the surface at a point of the scan, where the rings around it lie at least `least_spacing` [m] apart.
  /// Nothing where the point isn't on one straight line with those beside it, along its ring and across: at an edge, a corner, something small.
  [[nodiscard]] std::optional<Eigen::Vector3f> normal(const Point& point) const;

  static constexpr float least_spacing = 0.3F;

 private:
  static constexpr int columns = 720;
  static constexpr int most_rings = 256;

  [[nodiscard]] const Eigen::Vector3f* at(int row, int column) const;
  [[nodiscard]] const Eigen::Vector3f* nearest(int row, int column, int reach) const;

  std::vector<int> row_of_ring_;
  int rows_ = 0;
  std::vector<Eigen::Vector3f> cells_;  // zero: empty
};

}  // namespace sgraph
