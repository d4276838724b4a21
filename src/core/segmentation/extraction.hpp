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

/// What counts as on a plane, from the parameters and the noise of this cloud. A plane's own deviation is often smaller than the noise, as range
/// noise hardly moves points along a wall seen at a grazing angle; the same wall's nearest points are seen head-on and have all of it. So the noise
/// bounds the limit from below: a tighter one would cut off that end's points, and leave them to ghosts beside the wall.
struct Limits {
  const SegmentationParams& params;
  double noise = 0;  ///< standard deviation of points seen head-on [m]

  /// Largest distance of an inlier from a plane whose points have this standard deviation [m].
  [[nodiscard]] double distance(double sigma) const;
  /// Largest standard deviation of a plane's points: what an even spread between the limits would have is clutter [m].
  [[nodiscard]] double rms() const;
};

/// Least-squares plane of the members, trimmed a few times to the points within its own threshold. The normal keeps to the side of the plane that the
/// surface had. False, and the surface undefined, when fewer than three points remain or they lie on a line.
bool fit_trimmed(const PointSet& points, const Limits& limits, Surface& surface);

/// Whether a surface is large, dense and flat enough for a plane.
bool large_enough(const PointSet& points, const Surface& surface, const Limits& limits);

struct Extraction {
  std::vector<Surface> surfaces;  ///< those with the most support first
  double noise = 0;               ///< estimated from the cloud, see Limits [m]
};

/// Sequential RANSAC for surfaces of connected points.
Extraction extract_surfaces(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, const SegmentationParams& params);

}  // namespace sgraph
