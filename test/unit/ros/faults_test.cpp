// Recordings with something wrong in them: what is good is delivered, what isn't is left out and counted, and what can't be mapped at all is one
// clear line. Each row of the table is a fault and its outcome; docs/sensors.md lists them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <tf2_msgs/TFMessage.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

#include "sgraph_slam/ros/bag_source.hpp"
#include "sgraph_slam/ros/velodyne_scan.hpp"
#include "support/spinning_lidar.hpp"

namespace sgraph {
namespace {

namespace fs = std::filesystem;
using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

constexpr std::uint32_t t0 = 1'700'000'000;
constexpr int scans = 12;
constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinite = std::numeric_limits<float>::infinity();

ros::Time at(double seconds) { return ros::Time(t0) + ros::Duration(seconds); }

// x y z intensity ring time, packed as the velodyne driver does.
PointCloud2 message_of(const Cloud& cloud, double stamp) {
  PointCloud2 message;
  message.header.stamp = at(stamp);
  message.header.frame_id = "velodyne";
  message.height = 1;
  message.width = static_cast<std::uint32_t>(cloud.size());
  const std::vector<std::pair<const char*, std::uint8_t>> fields{{"x", PointField::FLOAT32},   {"y", PointField::FLOAT32},
                                                                 {"z", PointField::FLOAT32},   {"intensity", PointField::FLOAT32},
                                                                 {"ring", PointField::UINT16}, {"time", PointField::FLOAT32}};
  for (const auto& [name, type] : fields) {
    PointField field;
    field.name = name;
    field.offset = message.point_step;
    field.datatype = type;
    field.count = 1;
    message.fields.push_back(field);
    message.point_step += type == PointField::UINT16 ? 2 : 4;
  }
  message.row_step = message.point_step * message.width;
  message.data.resize(message.row_step);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    std::uint8_t* to = message.data.data() + i * message.point_step;
    const Point& p = cloud.points[i];
    const float numbers[4] = {p.x, p.y, p.z, p.intensity};
    std::memcpy(to, numbers, sizeof numbers);
    std::memcpy(to + 16, &p.ring, 2);
    std::memcpy(to + 18, &p.time, 4);
  }
  return message;
}

// Replaces one field's value at each point.
void each_float(PointCloud2& m, std::size_t field, const std::function<float(float, std::size_t)>& change) {
  for (std::size_t i = 0; i < m.width; ++i) {
    float value = 0;
    std::uint8_t* where = m.data.data() + i * m.point_step + m.fields[field].offset;
    std::memcpy(&value, where, 4);
    value = change(value, i);
    std::memcpy(where, &value, 4);
  }
}
void each_ring(PointCloud2& m, const std::function<std::uint16_t(std::uint16_t, std::size_t)>& change) {
  for (std::size_t i = 0; i < m.width; ++i) {
    std::uint16_t value = 0;
    std::memcpy(&value, m.data.data() + i * m.point_step + 16, 2);
    value = change(value, i);
    std::memcpy(m.data.data() + i * m.point_step + 16, &value, 2);
  }
}
void drop_field(PointCloud2& m, std::size_t field) { m.fields.erase(m.fields.begin() + static_cast<std::ptrdiff_t>(field)); }

// Widens each point by eight bytes that hold a double.
void add_double(PointCloud2& m, const char* name, const std::function<double(std::size_t)>& value) {
  std::vector<std::uint8_t> data;
  for (std::size_t i = 0; i < m.width; ++i) {
    const auto* from = m.data.data() + i * m.point_step;
    data.insert(data.end(), from, from + m.point_step);
    const double number = value(i);
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&number);
    data.insert(data.end(), bytes, bytes + 8);
  }
  PointField field;
  field.name = name;
  field.offset = m.point_step;
  field.datatype = PointField::FLOAT64;
  field.count = 1;
  m.fields.push_back(field);
  m.point_step += 8;
  m.row_step = m.point_step * m.width;
  m.data = data;
}

geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child, double x, double w = 1) {
  geometry_msgs::TransformStamped message;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform.translation.x = x;
  message.transform.rotation.w = w;
  return message;
}

struct Timed {
  double recorded;
  PointCloud2 cloud;
};

// A recording before it is written: twelve scans at 10 Hz, each received 5 ms after its stamp, the mount, an inertial unit and wheels.
struct Recording {
  std::vector<Timed> clouds;
  std::vector<sensor_msgs::Imu> imu;
  std::vector<nav_msgs::Odometry> odometry;
  std::vector<std::pair<double, geometry_msgs::TransformStamped>> fixed{{0, transform("base_link", "velodyne", 0.1)}};
  std::vector<std::pair<double, geometry_msgs::TransformStamped>> moving;
  std::vector<VelodyneScanMessage> packets;
  std::map<std::string, std::vector<Timed>> other_clouds;
  std::string topic = "/velodyne_points";
  rosbag::CompressionType compression = rosbag::compression::Uncompressed;
  std::function<void(const std::string& file)> spoil = [](const std::string&) {};
  double split = 1e9;    // messages recorded later go to a second file
  bool swapped = false;  // the second file is named first
  BagOptions options;

  PointCloud2& cloud(std::size_t i) { return clouds[i].cloud; }
  void each(const std::function<void(PointCloud2&, std::size_t)>& change) {
    for (std::size_t i = 0; i < clouds.size(); ++i) change(clouds[i].cloud, i);
  }
};

Recording good() {
  static const std::vector<PointCloud2> clouds = [] {
    test::SpinningLidar lidar;
    lidar.columns = 120;
    std::vector<PointCloud2> result;
    for (int i = 0; i < scans; ++i) result.push_back(message_of(lidar.scan(0), 0.1 * i));
    return result;
  }();
  Recording recording;
  for (std::size_t i = 0; i < clouds.size(); ++i) recording.clouds.push_back({0.1 * static_cast<double>(i) + 0.005, clouds[i]});
  for (int i = 0; i < 130; ++i) {
    sensor_msgs::Imu imu;
    imu.header.stamp = at(0.01 * i - 0.05);
    imu.header.frame_id = "base_link";
    imu.linear_acceleration.z = 9.81;
    recording.imu.push_back(imu);
    nav_msgs::Odometry odometry;
    odometry.header = imu.header;
    odometry.header.frame_id = "odom";
    odometry.child_frame_id = "base_link";
    odometry.pose.pose.orientation.w = 1;
    recording.odometry.push_back(odometry);
  }
  return recording;
}

struct Outcome {
  int delivered = scans;
  std::map<std::string, int> dropped{};  // by reason
  std::string error{};                   // part of the line
  std::string note{};                    // part of one
  int readings_left_out = 0;
};

struct Fault {
  const char* name;
  std::function<void(Recording&)> make;
  Outcome outcome;
};

Outcome refused(const std::string& error) { return {-1, {}, error, "", 0}; }
Outcome without(int count, const std::string& reason) { return {scans - count, {{reason, count}}, "", "", 0}; }
Outcome noted(const std::string& note) { return {scans, {}, "", note, 0}; }
Outcome readings(int count) { return {scans, {}, "", "", count}; }
const Outcome harmless{};

VelodyneScanMessage packets_of(double stamp, std::uint8_t product) {
  VelodyneScanMessage message;
  message.header.stamp = at(stamp);
  message.header.frame_id = "velodyne";
  for (int k = 0; k < 76; ++k) {
    VelodynePacket packet;
    packet.stamp = to_stamp(at(stamp - 0.00133 * (75 - k)));
    for (std::size_t block = 0; block < 12; ++block) {
      std::uint8_t* to = packet.data.data() + 100 * block;
      const int azimuth = static_cast<int>(std::lround((12 * k + static_cast<double>(block)) * 36000 / 912)) % 36000;
      to[0] = 0xFF, to[1] = 0xEE, to[2] = static_cast<std::uint8_t>(azimuth & 255), to[3] = static_cast<std::uint8_t>(azimuth >> 8);
      for (int laser = 0; laser < 32; ++laser) to[4 + 3 * laser] = 0, to[5 + 3 * laser] = 8, to[6 + 3 * laser] = 50;  // 4.096 m
    }
    packet.data[1204] = 0x37;
    packet.data[1205] = product;
    message.packets.push_back(packet);
  }
  return message;
}

void replace_file(const std::string& file, const std::function<void(std::vector<char>&)>& change) {
  std::ifstream in(file, std::ios::binary);
  std::vector<char> bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  change(bytes);
  std::ofstream(file, std::ios::binary | std::ios::trunc).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

std::function<void(Recording&)> cut(double share) {
  return [share](Recording& r) {
    r.spoil = [share](const std::string& file) {
      fs::resize_file(file, static_cast<std::uintmax_t>(share * static_cast<double>(fs::file_size(file))));
    };
  };
}

void with_imu(Recording& r) { r.options.imu_topic = "/imu"; }
void with_odometry(Recording& r) { r.options.odom_topic = "/odom"; }

std::vector<Fault> field_faults() {
  return {
      {"nothing wrong", [](Recording&) {}, harmless},
      {"a scan without x", [](Recording& r) { drop_field(r.cloud(5), 0); }, without(1, "missing_field")},
      {"a scan without y", [](Recording& r) { drop_field(r.cloud(5), 1); }, without(1, "missing_field")},
      {"a scan without z", [](Recording& r) { drop_field(r.cloud(5), 2); }, without(1, "missing_field")},
      {"a scan without fields", [](Recording& r) { r.cloud(5).fields.clear(); }, without(1, "missing_field")},
      {"the first scan without z", [](Recording& r) { drop_field(r.cloud(0), 2); }, without(1, "missing_field")},
      {"all scans without z", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { drop_field(m, 2); }); }, refused("no field z")},
      {"z has another name", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { m.fields[2].name = "height"; }); },
       refused("fields: x y height")},
      {"x of a scan is an integer", [](Recording& r) { r.cloud(5).fields[0].datatype = PointField::INT32; }, without(1, "field_type")},
      {"x is an integer", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { m.fields[0].datatype = PointField::INT32; }); },
       refused("field x is neither")},
      {"a type that isn't there, 0", [](Recording& r) { r.cloud(5).fields[3].datatype = 0; }, without(1, "field_type")},
      {"a type that isn't there, 99", [](Recording& r) { r.cloud(5).fields[3].datatype = 99; }, without(1, "field_type")},
      {"no ring", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { drop_field(m, 4); }); }, harmless},
      {"ring is always 0",
       [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { each_ring(m, [](std::uint16_t, std::size_t) { return std::uint16_t{0}; }); }); },
       harmless},
      {"ring is random",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t) {
           each_ring(m, [](std::uint16_t, std::size_t i) { return static_cast<std::uint16_t>(i * 7919 % 16); });
         });
       },
       harmless},
      {"ring counts to 65535",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t) { each_ring(m, [](std::uint16_t, std::size_t i) { return static_cast<std::uint16_t>(i * 7919); }); });
       },
       harmless},
      {"ring is a signed integer", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { m.fields[4].datatype = PointField::INT16; }); },
       harmless},
      {"rings counted from above",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t) { each_ring(m, [](std::uint16_t v, std::size_t) { return static_cast<std::uint16_t>(15 - v); }); });
       },
       harmless},
      {"no intensity", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { drop_field(m, 3); }); }, harmless},
      {"intensity is NaN",
       [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { each_float(m, 3, [](float, std::size_t) { return nan; }); }); }, harmless},
      {"times all 0", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { each_float(m, 5, [](float, std::size_t) { return 0.F; }); }); },
       harmless},
      {"no times", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { drop_field(m, 5); }); }, harmless},
      {"some times are NaN",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t) { each_float(m, 5, [](float v, std::size_t i) { return i % 9 == 0 ? nan : v; }); });
       },
       harmless},
      {"times in microseconds",
       [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { each_float(m, 5, [](float v, std::size_t) { return 1e6F * v; }); }); }, harmless},
      {"times of one scan in microseconds", [](Recording& r) { each_float(r.cloud(5), 5, [](float v, std::size_t) { return 1e6F * v; }); },
       without(1, "times")},
      {"times of one scan infinite", [](Recording& r) { each_float(r.cloud(5), 5, [](float, std::size_t) { return infinite; }); }, harmless},
      {"times of one scan a day away", [](Recording& r) { each_float(r.cloud(5), 5, [](float, std::size_t) { return 86400.F; }); },
       without(1, "times")},
      {"times counted backwards",
       [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { each_float(m, 5, [](float v, std::size_t) { return -v; }); }); }, harmless},
      {"absolute times in float32, good to two minutes",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t) {
           m.fields[5].name = "timestamp";
           each_float(m, 5, [](float, std::size_t) { return static_cast<float>(t0); });
         });
       },
       harmless},
      {"absolute times of another clock",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t k) {
           drop_field(m, 5);
           add_double(m, "timestamp", [k](std::size_t i) { return 777.0 + 0.1 * static_cast<double>(k) + 5e-5 * static_cast<double>(i); });
         });
       },
       harmless},
      {"fields that nobody knows",
       [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { add_double(m, "echo", [](std::size_t) { return 1e300; }); }); }, harmless},
      {"x twice", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { m.fields.push_back(m.fields[0]); }); }, harmless},
      {"counts of 0",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t) {
           for (auto& f : m.fields) f.count = 0;
         });
       },
       harmless},
  };
}

std::vector<Fault> layout_faults() {
  return {
      {"a count that reaches beyond the point", [](Recording& r) { r.cloud(5).fields[5].count = 3; }, without(1, "layout")},
      {"an offset beyond the point", [](Recording& r) { r.cloud(5).fields[3].offset = 100; }, without(1, "layout")},
      {"an offset of four thousand million", [](Recording& r) { r.cloud(5).fields[3].offset = 4294967295U; }, without(1, "layout")},
      {"x declared as float64, over y", [](Recording& r) { r.cloud(5).fields[0].datatype = PointField::FLOAT64; }, without(1, "layout")},
      {"x of all scans declared as float64",
       [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { m.fields[0].datatype = PointField::FLOAT64; }); },
       refused("field x at offset 0 reaches over field y")},
      {"ring declared as uint32, over time", [](Recording& r) { r.cloud(5).fields[4].datatype = PointField::UINT32; }, without(1, "layout")},
      {"y where x is", [](Recording& r) { r.cloud(5).fields[1].offset = 0; }, without(1, "layout")},
      {"z and intensity exchanged", [](Recording& r) { std::swap(r.cloud(5).fields[2].offset, r.cloud(5).fields[3].offset); }, without(1, "beams")},
      {"x and z exchanged", [](Recording& r) { std::swap(r.cloud(5).fields[0].offset, r.cloud(5).fields[2].offset); }, without(1, "beams")},
      {"upside down", [](Recording& r) { each_float(r.cloud(5), 2, [](float v, std::size_t) { return -v; }); }, without(1, "beams")},
      {"data shifted by two bytes", [](Recording& r) { std::rotate(r.cloud(5).data.begin(), r.cloud(5).data.begin() + 2, r.cloud(5).data.end()); },
       without(1, "beams")},
      {"data of another layout",
       [](Recording& r) {
         PointCloud2& m = r.cloud(5);
         for (std::size_t i = 0; i < m.data.size(); ++i) m.data[i] = static_cast<std::uint8_t>(i * 2654435761U >> 13);
       },
       without(1, "beams")},
      {"point_step 0", [](Recording& r) { r.cloud(5).point_step = 0; }, without(1, "layout")},
      {"point_step too large", [](Recording& r) { r.cloud(5).point_step = 1000; }, without(1, "layout")},
      {"point_step too small", [](Recording& r) { r.cloud(5).point_step = 10; }, without(1, "layout")},
      {"width too large", [](Recording& r) { r.cloud(5).width += 1; }, without(1, "layout")},
      {"width of four thousand million", [](Recording& r) { r.cloud(5).width = 4294967295U; }, without(1, "layout")},
      {"four thousand million points without bytes",
       [](Recording& r) {
         PointCloud2& m = r.cloud(5);
         m.width = m.height = 65536;
         m.row_step = 0;
         m.point_step = 0;
       },
       without(1, "layout")},
      {"height too large", [](Recording& r) { r.cloud(5).height = 2; }, without(1, "layout")},
      {"height 0", [](Recording& r) { r.cloud(5).height = 0; }, harmless},
      {"width 0", [](Recording& r) { r.cloud(5).width = 0; }, harmless},
      {"row_step too small", [](Recording& r) { r.cloud(5).row_step = 5; }, without(1, "layout")},
      {"row_step 0 in one row", [](Recording& r) { r.cloud(5).row_step = 0; }, harmless},
      {"row_step beyond the data", [](Recording& r) { r.cloud(5).row_step *= 2; }, without(1, "layout")},
      {"half of the data", [](Recording& r) { r.cloud(5).data.resize(r.cloud(5).data.size() / 2); }, without(1, "layout")},
      {"no data", [](Recording& r) { r.cloud(5).data.clear(); }, without(1, "layout")},
      {"more data than announced", [](Recording& r) { r.cloud(5).data.resize(r.cloud(5).data.size() + 77); }, harmless},
      {"big-endian", [](Recording& r) { r.cloud(5).is_bigendian = true; }, without(1, "big_endian")},
      {"all scans big-endian", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { m.is_bigendian = true; }); }, refused("big-endian")},
      {"organised, 16 rows", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { m.height = 16, m.width /= 16, m.row_step /= 16; }); },
       harmless},
      {"a scan of NaN", [](Recording& r) { each_float(r.cloud(5), 0, [](float, std::size_t) { return nan; }); }, harmless},
      {"a scan of infinities", [](Recording& r) { each_float(r.cloud(5), 0, [](float, std::size_t) { return infinite; }); }, harmless},
      {"a scan at the origin",
       [](Recording& r) {
         for (std::size_t f : {0U, 1U, 2U}) each_float(r.cloud(5), f, [](float, std::size_t) { return 0.F; });
       },
       harmless},
      {"coordinates of 1e30", [](Recording& r) { each_float(r.cloud(5), 0, [](float, std::size_t) { return 1e30F; }); }, without(1, "beams")},
      {"a scan of one point", [](Recording& r) { r.cloud(5).width = 1; }, harmless},
      {"half of a scan", [](Recording& r) { r.cloud(5).width /= 2; }, harmless},
      {"one scan in millimetres",
       [](Recording& r) {
         for (std::size_t f : {0U, 1U, 2U}) each_float(r.cloud(5), f, [](float v, std::size_t) { return 1000 * v; });
       },
       harmless},
      {"the first scan of NaN", [](Recording& r) { each_float(r.cloud(0), 0, [](float, std::size_t) { return nan; }); }, harmless},
      {"every third scan lies",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t i) {
           if (i % 3 == 1) std::swap(m.fields[0].offset, m.fields[2].offset);
         });
       },
       without(4, "beams")},
  };
}

std::vector<Fault> stamp_faults() {
  return {
      {"a stamp of 0", [](Recording& r) { r.cloud(5).header.stamp = ros::Time(); }, without(1, "stamp")},
      {"all stamps 0", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { m.header.stamp = ros::Time(); }); }, noted("has no stamps")},
      {"a stamp far in the future", [](Recording& r) { r.cloud(5).header.stamp += ros::Duration(1e6); }, without(1, "stamp")},
      {"the first stamp far in the future", [](Recording& r) { r.cloud(0).header.stamp += ros::Duration(1e6); }, without(1, "stamp")},
      {"the first stamp far in the past", [](Recording& r) { r.cloud(0).header.stamp -= ros::Duration(1e6); }, without(1, "stamp")},
      {"the last stamp far in the future", [](Recording& r) { r.cloud(11).header.stamp += ros::Duration(1e6); }, without(1, "stamp")},
      {"two stamps far in the future",
       [](Recording& r) { r.cloud(5).header.stamp += ros::Duration(1e6), r.cloud(6).header.stamp += ros::Duration(2e6); }, without(2, "stamp")},
      {"a stamp of 1970", [](Recording& r) { r.cloud(5).header.stamp = ros::Time(5, 0); }, without(1, "stamp")},
      {"a stamp twice", [](Recording& r) { r.cloud(5).header.stamp = r.cloud(4).header.stamp; }, harmless},
      {"all stamps the same", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { m.header.stamp = at(0); }); }, harmless},
      {"the clock set forward",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t i) {
           if (i > 5) m.header.stamp += ros::Duration(100);
         });
       },
       harmless},
      {"the clock set back",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t i) {
           if (i > 5) m.header.stamp -= ros::Duration(100);
         });
       },
       noted("clock was set back")},
      {"the clock set back by a second",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t i) {
           if (i > 5) m.header.stamp -= ros::Duration(1);
         });
       },
       harmless},
      {"stamps that jitter",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t i) { m.header.stamp += ros::Duration(0.01 * std::sin(7.0 * static_cast<double>(i))); });
       },
       harmless},
      {"stamps a year after the recording", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { m.header.stamp += ros::Duration(3e7); }); },
       harmless},
      {"stamps of another clock",
       [](Recording& r) { r.each([](PointCloud2& m, std::size_t i) { m.header.stamp = ros::Time(10 + 0.1 * static_cast<double>(i)); }); }, harmless},
      {"a pause of a minute",
       [](Recording& r) {
         for (std::size_t i = 6; i < r.clouds.size(); ++i) r.clouds[i].recorded += 60, r.cloud(i).header.stamp += ros::Duration(60);
       },
       harmless},
      {"two scans exchanged", [](Recording& r) { std::swap(r.clouds[5].cloud, r.clouds[6].cloud); }, harmless},
      {"a scan twice", [](Recording& r) { r.clouds.push_back(r.clouds[5]); }, {scans + 1, {}, "", "", 0}},
      {"recorded in bursts",
       [](Recording& r) {
         for (std::size_t i = 0; i < r.clouds.size(); ++i)
           r.clouds[i].recorded = 0.6 * static_cast<double>(i / 6 + 1) + 0.001 * static_cast<double>(i);
       },
       harmless},
      {"1 Hz",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t i) { m.header.stamp = at(static_cast<double>(i)); });
         for (std::size_t i = 0; i < r.clouds.size(); ++i) r.clouds[i].recorded = static_cast<double>(i) + 0.005;
       },
       harmless},
      {"every second scan is missing",
       [](Recording& r) {
         for (int i = 11; i > 0; i -= 2) r.clouds.erase(r.clouds.begin() + i);
       },
       {scans / 2, {}, "", "", 0}},
      {"one scan alone", [](Recording& r) { r.clouds.resize(1); }, {1, {}, "", "", 0}},
      {"no scan", [](Recording& r) { r.clouds.clear(); }, refused("no topic with clouds")},
  };
}

std::vector<Fault> frame_faults() {
  return {
      {"a scan without a frame", [](Recording& r) { r.cloud(5).header.frame_id = ""; }, without(1, "frame")},
      {"the first scan without a frame", [](Recording& r) { r.cloud(0).header.frame_id = ""; }, without(1, "frame")},
      {"a scan of another frame", [](Recording& r) { r.cloud(5).header.frame_id = "rear"; }, without(1, "frame")},
      {"the first scan of another frame", [](Recording& r) { r.cloud(0).header.frame_id = "rear"; }, without(1, "frame")},
      {"two LiDARs on the topic",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t i) {
           if (i % 2 == 1) m.header.frame_id = "rear";
         });
       },
       refused("several LiDARs share /velodyne_points: rear, velodyne; choose one with --lidar-frame")},
      {"two LiDARs on the topic, one chosen",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t i) {
           if (i % 2 == 1) m.header.frame_id = "rear";
         });
         r.options.lidar_frame = "velodyne";
       },
       without(6, "frame")},
      {"no scan names a frame", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { m.header.frame_id = ""; }); }, refused("name no frame")},
      {"no frames, the mount given",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t) { m.header.frame_id = ""; });
         r.options.T_base_lidar = Pose();
       },
       harmless},
      {"no frames, the LiDAR's given",
       [](Recording& r) {
         r.each([](PointCloud2& m, std::size_t) { m.header.frame_id = ""; });
         r.options.lidar_frame = "velodyne";
       },
       harmless},
      {"frames with slashes", [](Recording& r) { r.each([](PointCloud2& m, std::size_t) { m.header.frame_id = "/velodyne"; }); }, harmless},
      {"no transform", [](Recording& r) { r.fixed.clear(); }, refused("no transform from velodyne to base_link")},
      {"the transform comes at the end", [](Recording& r) { r.fixed[0].first = 1.2; }, harmless},
      {"the transform is NaN", [](Recording& r) { r.fixed[0].second.transform.translation.x = nan; }, refused("no transform from velodyne")},
      {"the transform has no rotation", [](Recording& r) { r.fixed[0].second.transform.rotation.w = 0; }, refused("no transform from velodyne")},
      {"another transform is NaN",
       [](Recording& r) {
         r.fixed.push_back({0, transform("base_link", "camera", nan)});
       },
       noted("base_link -> camera is left out")},
      {"the transform changes",
       [](Recording& r) {
         r.fixed.push_back({0.6, transform("base_link", "velodyne", 0.5)});
       },
       noted("changes within the recording")},
      {"the transform in /tf, constant",
       [](Recording& r) {
         r.fixed.clear();
         for (int i = 0; i < 12; ++i) r.moving.push_back({0.1 * i, transform("base_link", "velodyne", 0.1)});
       },
       noted("never changes in /tf")},
      {"the transform in /tf, moving",
       [](Recording& r) {
         r.fixed.clear();
         for (int i = 0; i < 12; ++i) r.moving.push_back({0.1 * i, transform("base_link", "velodyne", 0.1 * i)});
       },
       refused("no transform from velodyne to base_link")},
      {"transforms in a circle",
       [](Recording& r) {
         r.fixed.push_back({0, transform("velodyne", "base_link", 0.1)});
       },
       harmless},
      {"a frame that is its own parent",
       [](Recording& r) {
         r.fixed.push_back({0, transform("velodyne", "velodyne", 0.1)});
       },
       harmless},
      {"a transform between nameless frames",
       [](Recording& r) {
         r.fixed.push_back({0, transform("", "", 0.1)});
       },
       harmless},
      {"a chain with a link missing",
       [](Recording& r) {
         r.fixed = {{0, transform("base_link", "mast", 1)}, {0, transform("head", "velodyne", 1)}};
       },
       refused("base_link -> mast, head -> velodyne")},
      {"the base is another",
       [](Recording& r) {
         r.fixed = {{0, transform("body", "velodyne", 1)}};
       },
       refused("body -> velodyne")},
      {"the base is another, given",
       [](Recording& r) {
         r.fixed = {{0, transform("body", "velodyne", 1)}}, r.options.base_frame = "body";
       },
       harmless},
  };
}

std::vector<Fault> reading_faults() {
  return {
      {"inertial readings with NaN",
       [](Recording& r) {
         with_imu(r);
         for (std::size_t i = 0; i < 130; i += 13) r.imu[i].angular_velocity.x = nan;
       },
       readings(10)},
      {"inertial readings all NaN",
       [](Recording& r) {
         with_imu(r);
         for (auto& imu : r.imu) imu.linear_acceleration.y = nan;
       },
       readings(130)},
      {"inertial unit frozen",
       [](Recording& r) {
         with_imu(r);
         for (auto& imu : r.imu) imu.header.stamp = at(0.3);
       },
       harmless},
      {"inertial unit in degrees and g",
       [](Recording& r) {
         with_imu(r);
         for (auto& imu : r.imu) imu.angular_velocity.z = 57, imu.linear_acceleration.z = 1;
       },
       harmless},
      {"an inertial reading of another frame", [](Recording& r) { with_imu(r), r.imu[50].header.frame_id = "camera"; }, readings(1)},
      {"inertial frame unknown",
       [](Recording& r) {
         with_imu(r);
         for (auto& imu : r.imu) imu.header.frame_id = "imu_link";
       },
       refused("/imu: no transform from imu_link")},
      {"inertial unit falls silent", [](Recording& r) { with_imu(r), r.imu.resize(40); }, harmless},
      {"inertial stamps of 0",
       [](Recording& r) {
         with_imu(r);
         for (auto& imu : r.imu) imu.header.stamp = ros::Time();
       },
       harmless},
      {"no inertial readings", [](Recording& r) { with_imu(r), r.imu.clear(); }, refused("no topic /imu")},
      {"odometry with NaN",
       [](Recording& r) {
         with_odometry(r);
         for (std::size_t i = 0; i < 130; i += 13) r.odometry[i].pose.pose.position.x = nan;
       },
       readings(10)},
      {"odometry without rotations",
       [](Recording& r) {
         with_odometry(r);
         for (auto& odometry : r.odometry) odometry.pose.pose.orientation.w = 0;
       },
       readings(130)},
      {"odometry with covariances of NaN",
       [](Recording& r) {
         with_odometry(r);
         for (auto& odometry : r.odometry) odometry.pose.covariance[0] = nan;
       },
       harmless},
      {"odometry frozen",
       [](Recording& r) {
         with_odometry(r);
         for (auto& odometry : r.odometry) odometry.header.stamp = at(0.3);
       },
       harmless},
      {"odometry of another child among others", [](Recording& r) { with_odometry(r), r.odometry[50].child_frame_id = "gimbal"; }, readings(1)},
      {"odometry of an unknown child",
       [](Recording& r) {
         with_odometry(r);
         for (auto& odometry : r.odometry) odometry.child_frame_id = "gimbal";
       },
       refused("/odom: no transform from base_link to gimbal")},
      {"odometry without a child",
       [](Recording& r) {
         with_odometry(r);
         for (auto& odometry : r.odometry) odometry.child_frame_id = "";
       },
       harmless},
      {"odometry falls silent", [](Recording& r) { with_odometry(r), r.odometry.resize(40); }, harmless},
      {"odometry in the future",
       [](Recording& r) {
         with_odometry(r);
         for (auto& odometry : r.odometry) odometry.header.stamp += ros::Duration(1e6);
       },
       harmless},
      {"odometry that jumps", [](Recording& r) { with_odometry(r), r.odometry[60].pose.pose.position.x = 1e9; }, harmless},
  };
}

std::vector<Fault> bag_faults() {
  return {
      {"compressed with lz4", [](Recording& r) { r.compression = rosbag::compression::LZ4; }, harmless},
      {"compressed with bz2", [](Recording& r) { r.compression = rosbag::compression::BZ2; }, harmless},
      {"split over two files", [](Recording& r) { r.split = 0.6; }, harmless},
      {"split over two files, the later one first", [](Recording& r) { r.split = 0.6, r.swapped = true; }, harmless},
      {"cut at the head", cut(0.001), refused("truncated")},
      {"cut at a tenth", cut(0.1), refused("truncated")},
      {"cut at the middle", cut(0.5), refused("truncated")},
      {"cut before the end", cut(0.98), refused("truncated")},
      {"compressed and cut", [](Recording& r) { r.compression = rosbag::compression::LZ4, cut(0.7)(r); }, refused("truncated")},
      {"not closed: no index",
       [](Recording& r) {
         r.spoil = [](const std::string& file) {
           replace_file(file, [](std::vector<char>& bytes) {
             const std::string key = "index_pos=";
             const auto found = std::search(bytes.begin(), bytes.end(), key.begin(), key.end());
             std::fill_n(found + 10, 8, '\0');
           });
         };
       },
       refused("rosbag reindex")},
      {"a stretch of zeros in the middle",
       [](Recording& r) {
         r.compression = rosbag::compression::LZ4;
         r.spoil = [](const std::string& file) {
           replace_file(file,
                        [](std::vector<char>& bytes) { std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 3), 4096, '\0'); });
         };
       },
       refused("damaged")},
      {"an empty file", [](Recording& r) { r.spoil = [](const std::string& file) { fs::resize_file(file, 0); }; }, refused("is empty")},
      {"a text", [](Recording& r) { r.spoil = [](const std::string& file) { std::ofstream(file) << "no bag at all\n"; }; },
       refused("is not a ROS bag")},
      {"a folder", [](Recording& r) { r.spoil = [](const std::string& file) { fs::remove(file), fs::create_directory(file); }; },
       refused("is a folder")},
      {"no file", [](Recording& r) { r.spoil = [](const std::string& file) { fs::remove(file); }; }, refused("no such file")},
      {"another topic", [](Recording& r) { r.topic = "/eve/lidar3d"; }, harmless},
      {"another topic, the wrong one given", [](Recording& r) { r.topic = "/eve/lidar3d", r.options.points_topic = "/points"; },
       refused("no topic /points; topics of type sensor_msgs/PointCloud2 or velodyne_msgs/VelodyneScan: /eve/lidar3d")},
      {"two topics with clouds", [](Recording& r) { r.other_clouds["/rear"] = r.clouds; },
       refused("several topics hold clouds: /rear (12 messages), /velodyne_points (12 messages); choose one with --points-topic")},
      {"two topics with clouds, one chosen", [](Recording& r) { r.other_clouds["/rear"] = r.clouds, r.options.points_topic = "/velodyne_points"; },
       harmless},
      {"a topic that is none of clouds", [](Recording& r) { r.options.points_topic = "/imu"; }, refused("topic /imu is a sensor_msgs/Imu")},
      {"a start after the end", [](Recording& r) { r.options.start = 100; }, refused("no scan on /velodyne_points within the chosen time")},
      {"packets",
       [](Recording& r) {
         r.clouds.clear();
         for (int i = 0; i < scans; ++i) r.packets.push_back(packets_of(0.1 * i, 0x22));
       },
       harmless},
      {"clouds and packets", [](Recording& r) { r.packets.push_back(packets_of(0, 0x22)); }, harmless},
      {"packets of a product that isn't known",
       [](Recording& r) {
         r.clouds.clear();
         r.packets.push_back(packets_of(0, 0x77));
       },
       refused("product 119 can't be decoded")},
      {"packets with other packets among them",
       [](Recording& r) {
         r.clouds.clear();
         for (int i = 0; i < scans; ++i) r.packets.push_back(packets_of(0.1 * i, 0x22)), r.packets.back().packets[40].data[0] = 0;
       },
       harmless},
      {"a message without packets",
       [](Recording& r) {
         r.clouds.clear();
         for (int i = 0; i < scans; ++i) r.packets.push_back(packets_of(0.1 * i, 0x22));
         r.packets[5].packets.clear();
       },
       without(1, "layout")},
  };
}

class Faults : public testing::TestWithParam<Fault> {
 protected:
  Faults() : folder_(fs::temp_directory_path() / ("faults_test." + std::to_string(getpid()))) { fs::create_directories(folder_); }
  ~Faults() override { fs::remove_all(folder_); }

  std::vector<std::string> write(const Recording& r) const {
    std::vector<std::string> paths{(folder_ / "a.bag").string()};
    {
      rosbag::Bag first(paths[0], rosbag::bagmode::Write);
      first.setCompression(r.compression);
      std::unique_ptr<rosbag::Bag> second;
      if (r.split < 1e8) {
        paths.push_back((folder_ / "b.bag").string());
        second = std::make_unique<rosbag::Bag>(paths[1], rosbag::bagmode::Write);
      }
      const auto put = [&](const std::string& topic, double time, const auto& message) {
        (second && time > r.split ? *second : first).write(topic, at(time), message);
      };
      for (const auto& [time, one] : r.fixed) put("/tf_static", time, tf(one));
      for (const auto& [time, one] : r.moving) put("/tf", time, tf(one));
      for (std::size_t i = 0; i < r.imu.size(); ++i) put("/imu", 0.01 * static_cast<double>(i) - 0.04, r.imu[i]);
      for (std::size_t i = 0; i < r.odometry.size(); ++i) put("/odom", 0.01 * static_cast<double>(i) - 0.04, r.odometry[i]);
      for (const Timed& one : r.clouds) put(r.topic, one.recorded, one.cloud);
      for (const auto& [topic, clouds] : r.other_clouds) {
        for (const Timed& one : clouds) put(topic, one.recorded, one.cloud);
      }
      for (std::size_t i = 0; i < r.packets.size(); ++i) put("/velodyne_packets", 0.1 * static_cast<double>(i) + 0.005, r.packets[i]);
    }
    r.spoil(paths[0]);
    if (r.swapped) std::reverse(paths.begin(), paths.end());
    return paths;
  }

  static tf2_msgs::TFMessage tf(const geometry_msgs::TransformStamped& one) {
    tf2_msgs::TFMessage message;
    message.transforms.push_back(one);
    return message;
  }

  fs::path folder_;
};

TEST_P(Faults, Outcome) {
  Recording recording = good();
  GetParam().make(recording);
  recording.options.bags = write(recording);
  const Outcome& wanted = GetParam().outcome;
  int delivered = 0;
  std::string error;
  try {
    BagSource source(recording.options);
    while (const auto event = source.next()) {
      const auto* scan = std::get_if<CloudPtr>(&*event);
      if (scan == nullptr) continue;
      ++delivered;
      for (const Point& p : (*scan)->points) ASSERT_LE(std::abs(p.time), 2.0F);
    }
    std::map<std::string, int> dropped;
    for (const auto& [fault, count] : source.dropped()) dropped[to_string(fault)] = count;
    EXPECT_EQ(dropped, wanted.dropped);
    int left_out = 0;
    for (const auto& [what, count] : source.readings_dropped()) left_out += count;
    EXPECT_EQ(left_out, wanted.readings_left_out);
    std::string notes;
    for (const std::string& note : source.notes()) notes += note + '\n';
    EXPECT_THAT(notes, testing::HasSubstr(wanted.note));
  } catch (const std::runtime_error& caught) {
    error = caught.what();
  }
  if (wanted.error.empty()) {
    EXPECT_EQ(error, "");
    EXPECT_EQ(delivered, wanted.delivered);
  } else {
    EXPECT_THAT(error, testing::HasSubstr(wanted.error));
    EXPECT_EQ(error.find('\n'), std::string::npos);
  }
}

void PrintTo(const Fault& fault, std::ostream* to) { *to << fault.name; }

std::string name_of(const testing::TestParamInfo<Fault>& info) {
  std::string name;
  for (const char c : std::string(info.param.name)) name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Fields, Faults, testing::ValuesIn(field_faults()), name_of);
INSTANTIATE_TEST_SUITE_P(Layouts, Faults, testing::ValuesIn(layout_faults()), name_of);
INSTANTIATE_TEST_SUITE_P(Stamps, Faults, testing::ValuesIn(stamp_faults()), name_of);
INSTANTIATE_TEST_SUITE_P(Frames, Faults, testing::ValuesIn(frame_faults()), name_of);
INSTANTIATE_TEST_SUITE_P(Readings, Faults, testing::ValuesIn(reading_faults()), name_of);
INSTANTIATE_TEST_SUITE_P(Bags, Faults, testing::ValuesIn(bag_faults()), name_of);

}  // namespace
}  // namespace sgraph
