#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <std_msgs/Header.h>
#include <boost/shared_ptr.hpp>

#include <vector>

#include "sgraph_slam/core/sensor/velodyne_packets.hpp"
#include "sgraph_slam/ros/conversions.hpp"

/// velodyne_msgs/VelodyneScan, which Debian has no package of: declared here under its own name and checksum, for reading only.

namespace sgraph {

struct VelodyneScanMessage {
  std_msgs::Header header;
  std::vector<VelodynePacket> packets;
};
using VelodyneScanConstPtr = boost::shared_ptr<const VelodyneScanMessage>;

/// The points of the message's packets. `vertical_offsets` as in decode_velodyne.
Converted<RawScan> to_raw_scan(const VelodyneScanMessage& message, bool vertical_offsets, const std::optional<ros::Time>& received = std::nullopt);

}  // namespace sgraph

namespace ros {
namespace message_traits {

template <>
struct IsMessage<sgraph::VelodyneScanMessage> : TrueType {};
template <>
struct IsMessage<const sgraph::VelodyneScanMessage> : TrueType {};
template <>
struct HasHeader<sgraph::VelodyneScanMessage> : TrueType {};
template <>
struct MD5Sum<sgraph::VelodyneScanMessage> {
  static const char* value() { return "50804fc9533a0e579e6322c04ae70566"; }
  static const char* value(const sgraph::VelodyneScanMessage&) { return value(); }
};
template <>
struct DataType<sgraph::VelodyneScanMessage> {
  static const char* value() { return "velodyne_msgs/VelodyneScan"; }
  static const char* value(const sgraph::VelodyneScanMessage&) { return value(); }
};
template <>
struct Definition<sgraph::VelodyneScanMessage> {
  static const char* value() {
    return "std_msgs/Header header\n"
           "velodyne_msgs/VelodynePacket[] packets\n"
           "================================================================================\n"
           "MSG: std_msgs/Header\n"
           "uint32 seq\n"
           "time stamp\n"
           "string frame_id\n"
           "================================================================================\n"
           "MSG: velodyne_msgs/VelodynePacket\n"
           "time stamp\n"
           "uint8[1206] data\n";
  }
  static const char* value(const sgraph::VelodyneScanMessage&) { return value(); }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<sgraph::VelodyneScanMessage> {
  static void write(OStream& stream, const sgraph::VelodyneScanMessage& message) {
    stream.next(message.header);
    stream.next(static_cast<std::uint32_t>(message.packets.size()));
    for (const sgraph::VelodynePacket& packet : message.packets) {
      stream.next(sgraph::to_ros_time(packet.stamp));
      std::copy(packet.data.begin(), packet.data.end(), stream.advance(static_cast<std::uint32_t>(packet.data.size())));
    }
  }
  static void read(IStream& stream, sgraph::VelodyneScanMessage& message) {
    stream.next(message.header);
    std::uint32_t count = 0;
    stream.next(count);
    message.packets.clear();
    for (std::uint32_t i = 0; i < count; ++i) {  // one by one: a damaged count overruns the stream before it fills the memory
      ros::Time stamp;
      stream.next(stamp);
      message.packets.emplace_back();
      message.packets.back().stamp = sgraph::to_stamp(stamp);
      const std::uint8_t* data = stream.advance(static_cast<std::uint32_t>(sgraph::VelodynePacket::size));
      std::copy_n(data, sgraph::VelodynePacket::size, message.packets.back().data.begin());
    }
  }
  static std::uint32_t serializedLength(const sgraph::VelodyneScanMessage& message) {
    return serializationLength(message.header) + 4 + static_cast<std::uint32_t>(message.packets.size() * (8 + sgraph::VelodynePacket::size));
  }
};

}  // namespace serialization
}  // namespace ros
