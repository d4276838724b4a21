#pragma once

#include "sgraph_slam/core/prefilter/params.hpp"
#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// How many points came in and what each step dropped: `input` is the sum of the others.
struct PrefilterCounts {
  int input = 0;
  int invalid = 0;       ///< NaN or infinite position or time, or at the origin (the driver's "no return")
  int out_of_range = 0;  ///< outside min_range..max_range, or outside mean +- k sigma of the ranges (paper, Plane Extraction)
  int mixed = 0;         ///< between two surfaces: the beam struck an edge
  int voxel = 0;         ///< an earlier point of the same voxel was kept instead
  int outliers = 0;      ///< radius or statistical outliers
  int kept = 0;
};

struct FilteredScan {
  CloudPtr cloud;  ///< a subset of the points that came in, each unchanged and in their order; never null
  PrefilterCounts counts;
};

/// First stage: thins a raw scan and drops what can't be a surface. Stateless; same scan, same result.
///
/// Thinning keeps one point of each voxel, not the mean (a mean has no firing time and lies off the surface at edges) and not the point nearest the
/// voxel's centre: that choice depends on the noise and draws a wall that runs along the grid towards the centres of its cells. Nor is it the one
/// fired first (see `visit_scattered`). For the same reason the grid stands on a corner of its cells, with the vertical along their diagonal: were it
/// aligned with a floor that lies near a layer's boundary, the few points that the noise lifts into the next layer would count as much as all others,
/// and move the floor by half a sigma. Floors and walls, at every heading, cross this grid at 35 degrees or more to its axes, and the effect averages
/// out within a few cells. A plane gets about 1.4 to 1.7 points per leaf^2.
class Prefilter {
 public:
  /// Throws std::runtime_error when min_range isn't below max_range, or when the leaf is so small that cells can't be numbered.
  explicit Prefilter(const PrefilterParams& params);

  /// `raw` is in the LiDAR's frame, the sensor at the origin. May be empty. Safe to call from several threads.
  [[nodiscard]] FilteredScan process(const Cloud& raw) const;

 private:
  PrefilterParams params_;
};

}  // namespace sgraph
