#pragma once

#include <vector>

#include "plane_grid.hpp"
#include "point_set.hpp"
#include "sgraph_slam/core/segmentation/params.hpp"

namespace sgraph {

/// A plane found, with the part of space that it covers.
struct FlatSurface {
  Plane plane;       ///< faces the viewpoints of its points
  double sigma = 0;  ///< rms of the members' distances [m]
  double noise = 0;  ///< the same with each distance over its share of the noise, see Limits [m]
  Eigen::Matrix4d scatter = Eigen::Matrix4d::Zero();
  std::vector<std::uint32_t> members;  ///< positions in the point set, in order
  std::vector<Mask> masks;

  [[nodiscard]] bool covers(const Eigen::Vector3f& p) const {
    return std::any_of(masks.begin(), masks.end(), [&p](const Mask& mask) { return mask.holds(p); });
  }
};

/// What counts as on a plane, from the parameters and the noise of this cloud. Noise moves a point along its ray, so that only the cosine of the
/// angle of incidence of it is seen across the plane: the far end of a corridor's wall, seen at a grazing angle, looks ten times flatter than its
/// near end. One limit for both would cut the near end's points off and leave them to ghosts beside the wall, or take in what stands near the far
/// end.
struct Limits {
  static constexpr float least_share = 0.25F;  ///< what isn't range noise (motion, pointing) is the same at all angles

  const SegmentationParams& params;
  double noise = 0;  ///< standard deviation of points seen head-on [m]

  /// Share of the noise across a plane that a ray meets at this cosine.
  static float share(float cosine) { return std::max(cosine, least_share); }
  /// Largest distance of an inlier from a plane, by the cosine at which its ray meets it [m].
  struct Distance {
    float scale, low, high;
    [[nodiscard]] float operator()(float cosine) const { return std::min(std::max(scale * share(cosine), low), high); }
  };
  /// For a plane whose points have this noise; less than the cloud's isn't believed.
  [[nodiscard]] Distance distance(double surface_noise) const {
    return {static_cast<float>(params.threshold_sigmas * std::max(surface_noise, noise)), static_cast<float>(params.min_threshold),
            static_cast<float>(params.max_threshold)};
  }
  /// Largest rms distance of a plane's points [m].
  [[nodiscard]] double rms() const { return std::min(std::max(1.4 * noise, 0.01), params.max_rms); }
};

/// Positions in the set of the points on a plane, in order: within `factor` times the limit of each, and faced.
void collect_on(const PointSet& points, const PlaneF& plane, const Facing& facing, const Limits& limits, double surface_noise, float factor,
                std::vector<std::uint32_t>& inliers);

/// Least-squares plane of the members, trimmed a few times to the points within its own threshold. The normal keeps to the side of the plane that the
/// surface had. False, and the surface undefined, when fewer than three points remain or they lie on a line.
bool fit_trimmed(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, const Limits& limits, FlatSurface& surface);

/// Whether a surface is large, dense and flat enough for a plane.
bool large_enough(const PointSet& points, const FlatSurface& surface, const Limits& limits);

struct Extraction {
  std::vector<FlatSurface> surfaces;  ///< those with the most support first
  double noise = 0;                   ///< estimated from the cloud, see Limits [m]
};

/// Sequential RANSAC for surfaces of connected points.
Extraction extract_surfaces(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, const SegmentationParams& params);

}  // namespace sgraph
