#pragma once

#include <optional>

#include "sgraph_slam/core/sensor/raw_scan.hpp"
#include "sgraph_slam/core/sensor/ring_table.hpp"
#include "sgraph_slam/core/types/stamp.hpp"

namespace sgraph {

/// What one raw cloud shows of its driver's conventions.
struct CloudLook {
  Stamp stamp;
  std::optional<double> lag;  ///< from stamp to reception [s]
  double begin = 0, end = 0;  ///< azimuth of its first and last firing [rad]
  double swept = 0;           ///< from the first to the last firing, positive counter-clockwise [rad]; 0: not in order
  double coverage = 0;        ///< [rad]
  double step = 0;            ///< between firings of the same laser [rad]
  bool by_ring = false;       ///< points are ordered ring by ring
  int points = 0;
  double time_span = 0;   ///< in the field's unit; 0: all the same
  double time_first = 0;  ///< smallest value
  double time_trend = 0;  ///< correlation with the order in the message
};

/// Looks at a cloud. `table`: beams by which points without ring numbers are told apart.
[[nodiscard]] CloudLook look_at(const RawScan& raw, const std::optional<RingTable>& table);

}  // namespace sgraph
