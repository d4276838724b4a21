#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sgraph_slam/core/sensor/raw_scan.hpp"

namespace sgraph {

/// A data packet of a Velodyne sensor as it came over the network, and when its first firing was (the driver's stamp).
struct VelodynePacket {
  static constexpr std::size_t size = 1206;  ///< [bytes]
  Stamp stamp;
  std::array<std::uint8_t, size> data{};
};

struct DecodedPackets {
  RawScan scan;
  std::string model;  ///< by the product's number
  bool dual = false;  ///< two returns a firing
  int skipped = 0;    ///< packets that are none, or of another product
  std::string error;  ///< one sentence when nothing could be decoded; else empty
};

/// Decodes packets of one message (a turn, as the driver cuts them) of a VLP-16, Puck LITE, VLP-16 Hi-Res or HDL-32E, single or dual return (user
/// manuals 63-9243, 63-9113). Points are in the order of firing, in the axes of the ROS driver (x ahead, z up), rings counted from the lowest, times
/// in seconds from `stamp` by the sensor's own clock. A second return is left out where it is the first one. `stamp` is that of the first or the
/// last packet. `vertical_offsets`: add the height of each laser's origin (VLP-16), which the ROS driver leaves out.
DecodedPackets decode_velodyne(const std::vector<VelodynePacket>& packets, Stamp stamp, bool vertical_offsets);

}  // namespace sgraph
