#pragma once

#include "sgraph_slam/core/prefilter/params.hpp"
#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// How many points came in and what each step dropped.
struct PrefilterCounts {
  int input = 0;
  int invalid = 0;       ///< NaN, infinite, or at the origin (the driver's "no return")
  int out_of_range = 0;  ///< outside min_range..max_range, or outside mean +- k sigma of the ranges (paper, Plane Extraction)
  int voxel = 0;         ///< a neighbour in the same voxel was kept instead
  int outliers = 0;      ///< radius or statistical outliers
  int kept = 0;
};

struct FilteredScan {
  CloudPtr cloud;  ///< a subset of the points that came in, each unchanged; never null
  PrefilterCounts counts;
};

/// First stage: thins a raw scan and drops what can't be a surface. Stateless; same scan, same result.
class Prefilter {
 public:
  explicit Prefilter(const PrefilterParams& params) : params_(params) {}

  [[nodiscard]] FilteredScan process(const Cloud& raw) const;

 private:
  PrefilterParams params_;
};

}  // namespace sgraph
