#pragma once

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

struct SegmentationParams {
  double threshold = 0.05;
  int min_points = 100;

  void describe(ParamVisitor& v) {
    v.field("threshold", threshold, "m", {0.001, 1}, "Largest distance of an inlier from its plane.");
    v.field("min_points", min_points, "", {10, 100000}, "Smallest plane, in points.");
  }
};

}  // namespace sgraph
