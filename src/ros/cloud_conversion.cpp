#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include "sgraph_slam/ros/conversions.hpp"

namespace sgraph {
namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

// A sweep takes a fraction of a second; a larger offset is another unit or another clock.
constexpr double max_time_offset = 2.0;  // [s]

// A turn of a LiDAR with 128 beams has 0.3 million points, with two returns each; one that announces many more is no scan, and would fill the memory.
constexpr std::uint64_t most_points = 10'000'000;

// What is wrong with a message.
struct Refusal {
  MessageFault fault = MessageFault::none;
  std::string text;
};

std::size_t size_of(std::uint8_t datatype) {
  switch (datatype) {
    case PointField::INT8:
    case PointField::UINT8: return 1;
    case PointField::INT16:
    case PointField::UINT16: return 2;
    case PointField::INT32:
    case PointField::UINT32:
    case PointField::FLOAT32: return 4;
    case PointField::FLOAT64: return 8;
    default: return 0;
  }
}

bool is_float(const PointField& field) { return field.datatype == PointField::FLOAT32 || field.datatype == PointField::FLOAT64; }
bool is_unsigned(const PointField& field) {
  return field.datatype == PointField::UINT8 || field.datatype == PointField::UINT16 || field.datatype == PointField::UINT32;
}

const PointField* find(const PointCloud2& message, const char* name) {
  for (const PointField& field : message.fields) {
    if (field.name == name) return &field;
  }
  return nullptr;
}

std::string field_names(const PointCloud2& message) {
  std::string names;
  for (const PointField& field : message.fields) names += (names.empty() ? "" : " ") + field.name;
  return names.empty() ? "none" : names;
}

// Of the fields, those that this package reads.
constexpr std::array read_fields{"x", "y", "z", "intensity", "ring", "time", "t", "timestamp"};

bool is_read(const PointField& field) { return std::find(read_fields.begin(), read_fields.end(), field.name) != read_fields.end(); }

// Fields that are read and that share bytes: what the one holds can't be what the other says.
std::optional<std::string> overlap(const PointCloud2& message) {
  std::vector<const PointField*> fields;
  for (const char* name : read_fields) {
    if (const PointField* field = find(message, name)) fields.push_back(field);
  }
  for (const PointField* a : fields) {
    for (const PointField* b : fields) {
      if (a != b && a->offset <= b->offset && b->offset < a->offset + size_of(a->datatype)) {
        return "field " + a->name + " at offset " + std::to_string(a->offset) + " reaches over field " + b->name + " at offset " +
               std::to_string(b->offset);
      }
    }
  }
  return std::nullopt;
}

// What contradicts itself in the message's layout, or nothing.
std::optional<std::string> layout_error(const PointCloud2& message) {
  const std::uint64_t width = message.width;
  const std::uint64_t height = message.height;
  const std::uint64_t row = width * message.point_step;
  // Some drivers leave row_step 0 in a cloud of one row, where it says nothing.
  const std::uint64_t row_step = message.row_step == 0 && height == 1 ? row : message.row_step;
  if (row_step < row) {
    return "a row of " + std::to_string(width) + " points of " + std::to_string(message.point_step) + " bytes doesn't fit into row_step " +
           std::to_string(message.row_step);
  }
  if (width != 0 && row_step * height > message.data.size()) {
    return std::to_string(height) + " rows of " + std::to_string(row_step) + " bytes are announced, " + std::to_string(message.data.size()) +
           " bytes came";
  }
  for (const PointField& field : message.fields) {
    const std::uint64_t size = std::uint64_t{size_of(field.datatype)} * std::max<std::uint64_t>(field.count, 1);
    if (field.offset + size > message.point_step) {
      return "field " + field.name + " at offset " + std::to_string(field.offset) + " reaches beyond the point of " +
             std::to_string(message.point_step) + " bytes";
    }
  }
  if (width * height > most_points) return "it announces " + std::to_string(width * height) + " points";
  return overlap(message);
}

// Calls `take(point, value)` with the field's value at each point.
template <class T, class Take>
void each(const PointCloud2& message, const PointField& field, std::vector<Point>& points, Take take) {
  const std::size_t row_step = message.height == 1 ? 0 : message.row_step;
  for (std::size_t v = 0, i = 0; v < message.height; ++v) {
    const std::uint8_t* at = message.data.data() + v * row_step + field.offset;
    for (std::size_t u = 0; u < message.width; ++u, ++i, at += message.point_step) {
      T value;
      std::memcpy(&value, at, sizeof value);
      take(points[i], value);
    }
  }
}

template <class Take>
void each_number(const PointCloud2& message, const PointField& field, std::vector<Point>& points, Take take) {
  switch (field.datatype) {
    case PointField::INT8: return each<std::int8_t>(message, field, points, take);
    case PointField::UINT8: return each<std::uint8_t>(message, field, points, take);
    case PointField::INT16: return each<std::int16_t>(message, field, points, take);
    case PointField::UINT16: return each<std::uint16_t>(message, field, points, take);
    case PointField::INT32: return each<std::int32_t>(message, field, points, take);
    case PointField::UINT32: return each<std::uint32_t>(message, field, points, take);
    case PointField::FLOAT32: return each<float>(message, field, points, take);
    default: return each<double>(message, field, points, take);
  }
}

// The absolute time [s] from the cloud's stamp; whole seconds are taken off first, which keeps the fraction of a microsecond.
double since_stamp(double timestamp, const ros::Time& stamp) { return (timestamp - stamp.sec) - 1e-9 * stamp.nsec; }

// Fills the points' times; returns the largest offset that was found [s].
double read_times(const PointCloud2& message, const PointField& field, std::vector<Point>& points) {
  double largest = 0;
  const auto take = [&largest](Point& point, double offset) {
    if (!std::isfinite(offset)) return;  // of a point that is no return
    largest = std::max(largest, std::abs(offset));
    point.time = static_cast<float>(offset);
  };
  const ros::Time stamp = message.header.stamp;
  if (field.name == "timestamp") {
    // Some drivers count nanoseconds there.
    each_number(message, field, points, [&](Point& point, auto value) {
      const auto seconds = static_cast<double>(value);
      if (seconds != 0) take(point, since_stamp(seconds > 1e15 ? 1e-9 * seconds : seconds, stamp));
    });
  } else {
    const double unit = is_float(field) ? 1.0 : 1e-9;
    each_number(message, field, points, [&](Point& point, auto value) { take(point, unit * static_cast<double>(value)); });
  }
  return largest;
}

const PointField* time_field(const PointCloud2& message) {
  for (const char* name : {"time", "t", "timestamp"}) {
    if (const PointField* field = find(message, name)) return field;
  }
  return nullptr;
}

// Whether numbers may be of any type, or only of those that this package's own messages and the usual drivers have.
enum class Strictness { own_types, any_driver };

// What is wrong with the fields this package reads, or `none`.
Refusal check(const PointCloud2& message, Strictness strictness) {
  for (const char* name : {"x", "y", "z"}) {
    const PointField* field = find(message, name);
    if (field == nullptr) {
      return {MessageFault::missing_field, std::string("the cloud has no field ") + name + " (fields: " + field_names(message) + ")"};
    }
    if (!is_float(*field)) return {MessageFault::field_type, std::string("field ") + name + " is neither float32 nor float64"};
  }
  if (message.is_bigendian != 0) return {MessageFault::big_endian, "the cloud is big-endian"};
  for (const PointField& field : message.fields) {
    if (size_of(field.datatype) == 0 && (field.count > 0 || is_read(field))) {
      return {MessageFault::field_type, "field " + field.name + " has the unknown type " + std::to_string(field.datatype)};
    }
  }
  if (const auto error = layout_error(message)) return {MessageFault::layout, *error};
  if (strictness == Strictness::any_driver) return {};
  const PointField* ring = find(message, "ring");
  if (ring != nullptr && !is_unsigned(*ring)) return {MessageFault::field_type, "field ring is not an unsigned integer"};
  const PointField* time = time_field(message);
  if (time != nullptr && time->name == "timestamp" && time->datatype != PointField::FLOAT64) {
    return {MessageFault::field_type, "field timestamp is not float64"};
  }
  return {};
}

// Everything but the times.
Cloud without_times(const PointCloud2& message) {
  Cloud cloud;
  cloud.stamp = to_stamp(message.header.stamp);
  cloud.frame = frame_name(message.header.frame_id);
  auto& points = cloud.points;
  points.resize(std::size_t{message.width} * message.height);
  if (points.empty()) return cloud;
  each_number(message, *find(message, "x"), points, [](Point& point, auto value) { point.x = static_cast<float>(value); });
  each_number(message, *find(message, "y"), points, [](Point& point, auto value) { point.y = static_cast<float>(value); });
  each_number(message, *find(message, "z"), points, [](Point& point, auto value) { point.z = static_cast<float>(value); });
  if (const PointField* field = find(message, "intensity")) {
    each_number(message, *field, points, [](Point& point, auto value) { point.intensity = static_cast<float>(value); });
  }
  if (const PointField* field = find(message, "ring")) {
    each_number(message, *field, points, [](Point& point, auto value) {
      // What is no small whole number is no ring; converting it would be undefined.
      const auto number = static_cast<double>(value);
      point.ring = number >= 0 && number <= 65535 ? static_cast<std::uint16_t>(number) : std::uint16_t{65535};
    });
  }
  return cloud;
}

}  // namespace

Converted<CloudPtr> to_cloud(const PointCloud2& message) {
  if (const Refusal refusal = check(message, Strictness::own_types); refusal.fault != MessageFault::none)
    return {nullptr, refusal.fault, refusal.text};
  auto cloud = std::make_shared<Cloud>(without_times(message));
  if (cloud->empty()) return {cloud, MessageFault::none, ""};
  if (const PointField* field = time_field(message)) {
    const double largest = read_times(message, *field, cloud->points);
    if (largest > max_time_offset) {
      return {nullptr, MessageFault::times,
              "field " + field->name + " puts points " + std::to_string(largest) + " s away from the cloud's stamp: another unit or clock"};
    }
  }
  return {cloud, MessageFault::none, ""};
}

Converted<RawScan> to_raw_scan(const PointCloud2& message, const std::optional<ros::Time>& received) {
  if (const Refusal refusal = check(message, Strictness::any_driver); refusal.fault != MessageFault::none) return {{}, refusal.fault, refusal.text};
  Converted<RawScan> result;
  RawScan& raw = result.value;
  raw.cloud = without_times(message);
  raw.has_ring = find(message, "ring") != nullptr;
  raw.has_intensity = find(message, "intensity") != nullptr;
  if (received) raw.received = to_stamp(*received);
  const PointField* field = time_field(message);
  if (field == nullptr || raw.cloud.empty()) return result;
  raw.time_field = field->name;
  raw.integer_times = !is_float(*field);
  raw.times.reserve(raw.cloud.size());
  each_number(message, *field, raw.cloud.points, [&raw](Point&, auto value) { raw.times.push_back(static_cast<double>(value)); });
  return result;
}

}  // namespace sgraph
