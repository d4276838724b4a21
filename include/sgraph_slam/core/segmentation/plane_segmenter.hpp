#pragma once

#include "sgraph_slam/core/segmentation/params.hpp"
#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/segments.hpp"

namespace sgraph {

/// Third stage: finds the planar surfaces in a keyframe's cloud (paper, Plane Extraction). Deterministic: its random numbers depend on the
/// cloud alone.
class PlaneSegmenter {
 public:
  explicit PlaneSegmenter(const SegmentationParams& params) : params_(params) {}

  /// `cloud` is in the LiDAR's frame, with the origin at the sensor. `labels`, when given, gets for each point the index of its segment, or -1.
  [[nodiscard]] PlaneSegments process(const Cloud& cloud, std::vector<int>* labels = nullptr) const;

 private:
  SegmentationParams params_;
};

}  // namespace sgraph
