#pragma once

#include <vector>

#include <Eigen/Core>

#include "extraction.hpp"
#include "point_set.hpp"
#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/segments.hpp"

namespace sgraph {

/// Typical rms of the inliers of a keyframe's segments [m]: the median over them; 0 for none.
double usual_sigma(const std::vector<PlaneSegment>& segments);

/// Covariance of a segment's plane, as in PlaneSegment: white noise of the segment's own rms, and what the points of a beam and of a patch of the
/// surface share (core/math/noise.hpp). A segment rougher than `usual` [m] isn't one plane (a shelf's back against the wall, a bulge): what it
/// deviates is shared within patches. `viewpoints`: those of the point set; the cloud tells the beams.
Eigen::Matrix3d segment_covariance(const Cloud& cloud, const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints,
                                   const FlatSurface& surface, double usual);

}  // namespace sgraph
