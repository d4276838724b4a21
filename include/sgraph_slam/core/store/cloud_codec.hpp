#pragma once

#include <string>
#include <string_view>

#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

constexpr double stored_resolution = 0.001;  ///< of a stored coordinate [m]: a tenth of what the best spinning LiDARs resolve

/// A cloud compressed: positions to `stored_resolution`, times to 10 microseconds, intensities to 1 where they are whole numbers, else to a 65 535th
/// of the largest; rings, stamp and viewpoints exact. Points that are not finite, or further than 2 000 km away, are left out. Carries a checksum.
std::string encode_cloud(const Cloud& cloud);

/// Back from these bytes, points in their order. Throws std::runtime_error when they are damaged.
Cloud decode_cloud(std::string_view bytes);

}  // namespace sgraph
