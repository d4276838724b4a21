// What a LiDAR's driver sends, made of arbitrary bytes. PointCloud2: the first bytes describe its header, as a driver would that lies about its
// layout; the rest is the data. VelodyneScan: the message as it comes over the wire.
#include <ros/serialization.h>
#include <sensor_msgs/PointCloud2.h>

#include <array>
#include <cmath>
#include <cstring>

#include "readers.hpp"
#include "sgraph_slam/core/prefilter/prefilter.hpp"
#include "sgraph_slam/core/sensor/sensor_adapter.hpp"
#include "sgraph_slam/ros/conversions.hpp"
#include "sgraph_slam/ros/velodyne_scan.hpp"

namespace sgraph::fuzz {

namespace {

/// Takes numbers off the front; zeros when there is nothing left.
class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  T take() {
    T value{};
    const std::size_t size = std::min(sizeof(T), bytes_.size());
    std::memcpy(&value, bytes_.data(), size);
    bytes_.remove_prefix(size);
    return value;
  }

  [[nodiscard]] std::string_view rest() const { return bytes_; }

 private:
  std::string_view bytes_;
};

constexpr std::array<const char*, 12> names{"x", "y", "z", "intensity", "ring", "time", "t", "timestamp", "rgb", "", "X", "range"};

// A scan on its way through the first stages; twice the same, as a driver's conventions stay.
void adapt(const RawScan& raw) {
  SensorAdapter adapter{SensorParams{}};
  AdaptedScans adapted = adapter.take(raw);
  RawScan next = raw;
  next.cloud.stamp = next.cloud.stamp.after(0.1);
  const AdaptedScans second = adapter.take(std::move(next));
  adapted.scans.insert(adapted.scans.end(), second.scans.begin(), second.scans.end());
  const AdaptedScans held = adapter.flush();
  adapted.scans.insert(adapted.scans.end(), held.scans.begin(), held.scans.end());
  static const Prefilter prefilter{PrefilterParams{}};
  for (const CloudPtr& cloud : adapted.scans) {
    expect(cloud->size() <= 2 * raw.cloud.size(), "a scan has no more points than were sent");
    const FilteredScan scan = prefilter.process(*cloud);
    expect(scan.cloud->size() <= cloud->size(), "thinning adds no points");
    for (const auto& point : scan.cloud->points) {
      expect(std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z), "points that are kept are finite");
      expect(std::isfinite(point.time), "times that are kept are finite");
    }
  }
}

}  // namespace

void read_velodyne_scan(std::string_view data) {
  VelodyneScanMessage message;
  std::string bytes(data);  // the stream wants to be able to write
  ros::serialization::IStream stream(reinterpret_cast<std::uint8_t*>(bytes.data()), static_cast<std::uint32_t>(bytes.size()));
  try {
    ros::serialization::deserialize(stream, message);
  } catch (const ros::serialization::StreamOverrunException&) {
    return;  // ROS drops the message
  }
  const Converted<RawScan> raw = to_raw_scan(message, true);
  if (!raw) {
    expect(!raw.text.empty(), "a refusal has a reason");
    return;
  }
  expect(raw.value.times.size() == raw.value.cloud.size(), "every point has a time");
  adapt(raw.value);
}

void read_point_cloud(std::string_view data) {
  Bytes bytes(data);
  sensor_msgs::PointCloud2 message;
  message.header.stamp = ros::Time(bytes.take<std::uint32_t>(), bytes.take<std::uint32_t>() % 1'000'000'000U);
  message.height = bytes.take<std::uint16_t>();
  message.width = bytes.take<std::uint16_t>();
  message.point_step = bytes.take<std::uint16_t>();
  message.row_step = bytes.take<std::uint32_t>();
  const auto flags = bytes.take<std::uint8_t>();
  message.is_bigendian = (flags & 1U) != 0;
  message.is_dense = (flags & 2U) != 0;
  if ((flags & 4U) != 0) message.width <<= 16U;
  if ((flags & 8U) != 0) message.row_step = message.width * message.point_step;
  const std::size_t fields = bytes.take<std::uint8_t>() % 12U;
  for (std::size_t i = 0; i < fields; ++i) {
    sensor_msgs::PointField field;
    field.name = names[bytes.take<std::uint8_t>() % names.size()];
    field.offset = bytes.take<std::uint8_t>();
    if (field.offset == 255) field.offset = 0xffffffffU;
    field.datatype = bytes.take<std::uint8_t>() % 10;
    field.count = bytes.take<std::uint8_t>();
    message.fields.push_back(field);
  }
  message.data.assign(bytes.rest().begin(), bytes.rest().end());

  const Converted<CloudPtr> cloud = to_cloud(message);
  if (!cloud) {
    expect(!cloud.text.empty(), "a refusal has a reason");
    return;
  }
  expect(cloud.value->size() <= message.data.size(), "no more points than bytes");
  if (const Converted<RawScan> raw = to_raw_scan(message)) adapt(raw.value);
}

}  // namespace sgraph::fuzz
