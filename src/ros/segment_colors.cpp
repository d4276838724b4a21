#include "sgraph_slam/ros/segment_colors.hpp"

#include <array>
#include <cstring>

#include "sgraph_slam/ros/conversions.hpp"

namespace sgraph {

namespace {

// Twelve colours that stay apart on a dark background; 0xRRGGBB.
constexpr std::array<std::uint32_t, 12> palette{0x4e79ff, 0xff9d4e, 0x3ecf5a, 0xff5a5f, 0xb07aff, 0xd8a47f,
                                                0xff7ad9, 0xd4d43a, 0x2ad4d4, 0x9fd0ff, 0xffd39f, 0x8fff9f};
constexpr std::uint32_t unassigned = 0x606060;

}  // namespace

sensor_msgs::PointCloud2 colored_cloud(const Cloud& cloud, const std::vector<int>& labels) {
  constexpr std::uint32_t step = 16;
  sensor_msgs::PointCloud2 message;
  message.header.stamp = to_ros_time(cloud.stamp);
  message.header.frame_id = cloud.frame;
  message.height = 1;
  message.width = static_cast<std::uint32_t>(cloud.size());
  message.point_step = step;
  message.row_step = message.width * step;
  message.is_dense = true;
  for (const char* name : {"x", "y", "z", "rgb"}) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = 4 * static_cast<std::uint32_t>(message.fields.size());
    field.datatype = sensor_msgs::PointField::FLOAT32;  // rgb too: its bits are the colour
    field.count = 1;
    message.fields.push_back(field);
  }
  message.data.resize(message.row_step);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Point& p = cloud.points[i];
    const int label = i < labels.size() ? labels[i] : -1;
    const std::uint32_t color = label < 0 ? unassigned : palette[static_cast<std::size_t>(label) % palette.size()];
    std::uint8_t* at = &message.data[i * step];
    std::memcpy(at, &p.x, 4);
    std::memcpy(at + 4, &p.y, 4);
    std::memcpy(at + 8, &p.z, 4);
    std::memcpy(at + 12, &color, 4);
  }
  return message;
}

}  // namespace sgraph
