#include "sgraph_slam/ros/simulated_bag.hpp"

#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <cstring>
#include <stdexcept>

namespace sgraph {

namespace {

constexpr std::size_t point_step = 22;

ros::Time time_of(Stamp stamp) {
  ros::Time time;
  time.fromNSec(static_cast<std::uint64_t>(stamp.nanoseconds));
  return time;
}

sensor_msgs::PointField field(const char* name, std::uint32_t offset, std::uint8_t type) {
  sensor_msgs::PointField f;
  f.name = name;
  f.offset = offset;
  f.datatype = type;
  f.count = 1;
  return f;
}

sensor_msgs::PointCloud2 message_of(const Cloud& cloud, std::uint32_t number) {
  using sensor_msgs::PointField;
  sensor_msgs::PointCloud2 message;
  message.header.seq = number;
  message.header.stamp = time_of(cloud.stamp);
  message.header.frame_id = cloud.frame;
  message.height = 1;
  message.width = static_cast<std::uint32_t>(cloud.size());
  message.fields = {field("x", 0, PointField::FLOAT32),          field("y", 4, PointField::FLOAT32),    field("z", 8, PointField::FLOAT32),
                    field("intensity", 12, PointField::FLOAT32), field("ring", 16, PointField::UINT16), field("time", 18, PointField::FLOAT32)};
  message.point_step = point_step;
  message.row_step = static_cast<std::uint32_t>(point_step * cloud.size());
  message.is_dense = 1;
  message.data.resize(point_step * cloud.size());
  std::uint8_t* to = message.data.data();
  for (const Point& p : cloud.points) {
    const float numbers[4] = {p.x, p.y, p.z, p.intensity};
    std::memcpy(to, numbers, sizeof numbers);
    std::memcpy(to + 16, &p.ring, sizeof p.ring);
    std::memcpy(to + 18, &p.time, sizeof p.time);
    to += point_step;
  }
  return message;
}

template <class Vector>
void fill(Vector& to, const Eigen::Vector3d& from) {
  to.x = from.x();
  to.y = from.y();
  to.z = from.z();
}

template <class Quaternion>
void fill(Quaternion& to, const Eigen::Quaterniond& from) {
  to.x = from.x();
  to.y = from.y();
  to.z = from.z();
  to.w = from.w();
}

nav_msgs::Odometry message_of(const sim::EncoderReading& reading) {
  nav_msgs::Odometry message;
  message.header.stamp = time_of(reading.sample.stamp);
  message.header.frame_id = "odom";
  message.child_frame_id = "base_link";
  fill(message.pose.pose.position, reading.sample.T_odom_base.translation);
  fill(message.pose.pose.orientation, reading.sample.T_odom_base.rotation);
  message.twist.twist.linear.x = reading.forward;
  message.twist.twist.linear.y = reading.sideways;
  message.twist.twist.angular.z = reading.turning;
  for (int i = 0; i < 6; ++i) {  // the message has the translation first
    for (int j = 0; j < 6; ++j) message.pose.covariance[static_cast<std::size_t>(6 * ((i + 3) % 6) + (j + 3) % 6)] = reading.sample.covariance(i, j);
  }
  return message;
}

sensor_msgs::Imu message_of(const ImuSample& sample) {
  sensor_msgs::Imu message;
  message.header.stamp = time_of(sample.stamp);
  message.header.frame_id = "base_link";
  message.orientation_covariance[0] = -1;  // gives no orientation
  fill(message.angular_velocity, sample.angular_velocity);
  fill(message.linear_acceleration, sample.linear_acceleration);
  return message;
}

void write_transform(rosbag::Bag& bag, const Pose& T_base_lidar, const std::string& frame, Stamp stamp) {
  tf2_msgs::TFMessage message;
  message.transforms.resize(1);
  message.transforms[0].header.stamp = time_of(stamp);
  message.transforms[0].header.frame_id = "base_link";
  message.transforms[0].child_frame_id = frame;
  fill(message.transforms[0].transform.translation, T_base_lidar.translation);
  fill(message.transforms[0].transform.rotation, T_base_lidar.rotation);
  auto connection = boost::make_shared<ros::M_string>();
  (*connection)["topic"] = "/tf_static";
  (*connection)["type"] = ros::message_traits::datatype(message);
  (*connection)["md5sum"] = ros::message_traits::md5sum(message);
  (*connection)["message_definition"] = ros::message_traits::definition(message);
  (*connection)["latching"] = "1";
  (*connection)["callerid"] = "/robot_state_publisher";
  bag.write("/tf_static", time_of(stamp), message, connection);
}

}  // namespace

void write_simulated_bag(sim::SimulatedSource& source, const std::string& path, const std::function<void(int)>& progress) {
  try {
    rosbag::Bag bag(path, rosbag::bagmode::Write);
    bag.setCompression(rosbag::compression::LZ4);
    const sim::LidarSettings& settings = source.lidar().settings();
    write_transform(bag, source.T_base_lidar(), settings.frame, {settings.start});
    int scans = 0;
    while (const auto event = source.next()) {
      const ros::Time arrival = time_of(source.last_arrival());
      if (const auto* cloud = std::get_if<CloudPtr>(&*event)) {
        bag.write("/velodyne_points", arrival, message_of(**cloud, static_cast<std::uint32_t>(scans)));
        progress(++scans);
      } else if (std::holds_alternative<OdometrySample>(*event)) {
        bag.write("/odom", arrival, message_of(source.last_encoder_reading()));
      } else {
        bag.write("/imu/data", arrival, message_of(std::get<ImuSample>(*event)));
      }
    }
    bag.close();
  } catch (const rosbag::BagException& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

}  // namespace sgraph
