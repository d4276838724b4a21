#include "sgraph_slam/ros/cloud_message.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace sgraph {

namespace {

using Field = sensor_msgs::PointField;

// One point on the wire, without gaps, as the velodyne driver lays it out.
constexpr std::uint32_t x_at = 0;
constexpr std::uint32_t y_at = 4;
constexpr std::uint32_t z_at = 8;
constexpr std::uint32_t intensity_at = 12;
constexpr std::uint32_t time_at = 16;
constexpr std::uint32_t ring_at = 20;
constexpr std::uint32_t point_step = 22;

Field field(const char* name, std::uint32_t offset, std::uint8_t datatype) {
  Field result;
  result.name = name;
  result.offset = offset;
  result.datatype = datatype;
  result.count = 1;
  return result;
}

/// The message without its data, and the data's size.
sensor_msgs::PointCloud2 header_of(const Cloud& cloud) {
  sensor_msgs::PointCloud2 message;
  message.header.stamp = to_ros_time(cloud.stamp);
  message.header.frame_id = cloud.frame;
  message.height = 1;
  message.width = static_cast<std::uint32_t>(cloud.size());
  message.fields = {field("x", x_at, Field::FLOAT32),       field("y", y_at, Field::FLOAT32),
                    field("z", z_at, Field::FLOAT32),       field("intensity", intensity_at, Field::FLOAT32),
                    field("time", time_at, Field::FLOAT32), field("ring", ring_at, Field::UINT16)};
  message.is_bigendian = false;
  message.point_step = point_step;
  message.row_step = message.width * point_step;
  message.is_dense = std::all_of(cloud.points.begin(), cloud.points.end(), [](const Point& p) { return p.position().allFinite(); });
  return message;
}

void put(std::uint8_t* target, const Point& point) {
  std::memcpy(target + x_at, &point.x, sizeof point.x);
  std::memcpy(target + y_at, &point.y, sizeof point.y);
  std::memcpy(target + z_at, &point.z, sizeof point.z);
  std::memcpy(target + intensity_at, &point.intensity, sizeof point.intensity);
  std::memcpy(target + time_at, &point.time, sizeof point.time);
  std::memcpy(target + ring_at, &point.ring, sizeof point.ring);
}

}  // namespace

}  // namespace sgraph

namespace ros {
namespace serialization {

void Serializer<sgraph::Cloud>::write(OStream& stream, const sgraph::Cloud& cloud) {
  const sensor_msgs::PointCloud2 message = sgraph::header_of(cloud);
  stream.next(message.header);
  stream.next(message.height);
  stream.next(message.width);
  stream.next(message.fields);
  stream.next(message.is_bigendian);
  stream.next(message.point_step);
  stream.next(message.row_step);
  stream.next(message.row_step);  // size of the data
  std::uint8_t* target = stream.advance(message.row_step);
  for (const sgraph::Point& point : cloud.points) {
    sgraph::put(target, point);
    target += sgraph::point_step;
  }
  stream.next(message.is_dense);
}

void Serializer<sgraph::Cloud>::read(IStream& stream, sgraph::Cloud& cloud) {
  sensor_msgs::PointCloud2 message;
  stream.next(message);
  const sgraph::Converted<sgraph::CloudPtr> converted = sgraph::to_cloud(message);
  if (!converted) throw std::runtime_error(converted.text);
  cloud = *converted.value;
}

std::uint32_t Serializer<sgraph::Cloud>::serializedLength(const sgraph::Cloud& cloud) {
  return serializationLength(sgraph::header_of(cloud)) + static_cast<std::uint32_t>(cloud.size()) * sgraph::point_step;
}

}  // namespace serialization
}  // namespace ros
