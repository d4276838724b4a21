#pragma once

#include <cstdint>
#include <vector>

#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// Mixed pixels: a beam that strikes an edge lies partly on what is near and partly on what is behind it, and the sensor reports a range between the
/// two, where nothing is. Such a point lies between its neighbours on the ring and continues neither of their surfaces.
///
/// Returns a mark for each point, 1 for a mixed pixel. `raw`: in the LiDAR's frame, each ring's points in the order of their azimuth (however the
/// rings follow each other). What stands clear of its background is never marked, however thin: it is nearer than both its neighbours. Nor is a
/// surface that is seen at a grazing angle: along it the inverse of the range goes on evenly.
std::vector<std::uint8_t> mixed_pixels(const Cloud& raw);

}  // namespace sgraph
