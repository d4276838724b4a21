#pragma once

#include <vector>

#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph::test {

/// A spinning LiDAR in a box-shaped room, by plain geometry: for tests of conventions.
struct SpinningLidar {
  std::vector<double> elevations_deg = vlp16();  ///< in the order of firing
  std::vector<double> vertical_offsets;          ///< of each laser's origin [m]; empty: none
  int columns = 1800;                            ///< firings of all lasers a turn
  double turn = 0.1;                             ///< [s]
  bool clockwise = true;
  double begin_deg = 0;  ///< azimuth of the first firing

  static std::vector<double> vlp16();
  static std::vector<double> evenly(double low, double high, int count);

  /// A turn in the order of firing, seen from 1.2 m above the floor of a room of 8 x 6 x 2.8 m; times from the stamp, which is that of the last
  /// firing, at `stamp` seconds. Rings are counted from the lowest.
  [[nodiscard]] Cloud scan(double stamp) const;
};

}  // namespace sgraph::test
