#pragma once

#include <vector>

#include "sgraph_slam/core/segmentation/params.hpp"
#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/segments.hpp"

namespace sgraph {

/// Third stage: finds the planar surfaces in a keyframe's cloud (paper, Plane Extraction). Deterministic: its random numbers depend on the
/// cloud alone. Stateless and safe to call from several threads.
///
/// Sequential RANSAC: hypotheses from small neighbourhoods, the best one by a truncated quadratic score that counts points beside the plane
/// against it; refit on the inliers; split into connected pieces on the plane; pieces that are coplanar within the noise and near each other are one
/// segment. Parts of a surface on another level than most of it (a shelf's back a hand's breadth before the wall) are no part of it. At last each
/// point goes to the nearest plane, points near the edge of two planes go to neither, and all planes are fitted anew.
class PlaneSegmenter {
 public:
  /// Throws std::runtime_error when thresholds or gaps contradict each other.
  explicit PlaneSegmenter(const SegmentationParams& params);

  /// `cloud` is in the LiDAR's frame, with the origin at the sensor. `labels`, when given, gets for each point the index of its segment, or -1.
  /// Segments come in order of their number of points, most first. Normals point to where their surface was seen from.
  ///
  /// In a cloud put together from several scans the points' times and the cloud's viewpoints tell from where each was seen. A point belongs only to a
  /// plane on whose free side the LiDAR was when it fired, so the faces of a wall stay apart when the robot went through its door; `d` is negative
  /// for a face whose plane the LiDAR has passed since. With no viewpoints all is seen from the origin, and `d` is positive.
  [[nodiscard]] PlaneSegments process(const Cloud& cloud, std::vector<int>* labels = nullptr) const;

 private:
  SegmentationParams params_;
};

}  // namespace sgraph
