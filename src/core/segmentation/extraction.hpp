#pragma once

#include <vector>

#include "plane_grid.hpp"
#include "point_set.hpp"
#include "sgraph_slam/core/segmentation/params.hpp"

namespace sgraph {

/// A plane found, with the part of space that it covers.
struct Surface {
  Plane plane;       ///< faces the viewpoints of its points
  double sigma = 0;  ///< rms of the members' distances [m]
  Eigen::Matrix4d scatter = Eigen::Matrix4d::Zero();
  std::vector<std::uint32_t> members;  ///< positions in the point set, in order
  std::vector<Mask> masks;

  [[nodiscard]] bool covers(const Eigen::Vector3f& p) const {
    return std::any_of(masks.begin(), masks.end(), [&p](const Mask& mask) { return mask.holds(p); });
  }
};

/// Largest distance of an inlier from a plane whose points have this standard deviation [m].
double inlier_threshold(double sigma, const SegmentationParams& params);

/// Least-squares plane of the members, trimmed a few times to the points within its own threshold. The normal keeps to the side of the plane that the
/// surface had. False, and the surface undefined, when fewer than three points remain or they lie on a line.
bool fit_trimmed(const PointSet& points, const SegmentationParams& params, Surface& surface);

/// Whether a surface is large, dense and flat enough for a plane.
bool large_enough(const PointSet& points, const Surface& surface, const SegmentationParams& params);

/// Sequential RANSAC: surfaces of connected points, those with the most support first.
std::vector<Surface> extract_surfaces(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, const SegmentationParams& params);

}  // namespace sgraph
