#include "sgraph_slam/ros/velodyne_scan.hpp"

namespace sgraph {

Converted<RawScan> to_raw_scan(const VelodyneScanMessage& message, bool vertical_offsets, const std::optional<ros::Time>& received) {
  DecodedPackets decoded = decode_velodyne(message.packets, to_stamp(message.header.stamp), vertical_offsets);
  if (!decoded.error.empty()) return {{}, MessageFault::layout, decoded.error};
  decoded.scan.cloud.frame = frame_name(message.header.frame_id);
  if (received) decoded.scan.received = to_stamp(*received);
  return {std::move(decoded.scan), MessageFault::none, ""};
}

}  // namespace sgraph
