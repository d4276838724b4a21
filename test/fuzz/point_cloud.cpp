// A PointCloud2 made of arbitrary bytes. The first describe its header, as a driver would that lies about its layout; the rest is the data.
#include <sensor_msgs/PointCloud2.h>

#include <array>
#include <cmath>
#include <cstring>

#include "readers.hpp"
#include "sgraph_slam/core/prefilter/prefilter.hpp"
#include "sgraph_slam/ros/conversions.hpp"

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

}  // namespace

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
  static const Prefilter prefilter{PrefilterParams{}};
  const FilteredScan scan = prefilter.process(*cloud.value);
  expect(scan.cloud->size() <= cloud.value->size(), "thinning adds no points");
  for (const auto& point : scan.cloud->points)
    expect(std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z), "points that are kept are finite");
}

}  // namespace sgraph::fuzz
