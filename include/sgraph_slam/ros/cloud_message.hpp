#pragma once

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <sensor_msgs/PointCloud2.h>
#include <boost/shared_ptr.hpp>

#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/ros/conversions.hpp"

/// Makes `sgraph::Cloud` a message of its own: published and subscribed as it is, it passes between the nodelets of one process as a pointer, and
/// is a sensor_msgs/PointCloud2 (x y z intensity time ring) to everybody else. Publish it with `to_boost` of shared_pointer.hpp and subscribe
/// `const CloudMessage&`.

namespace sgraph {

using CloudMessage = boost::shared_ptr<const Cloud>;

}  // namespace sgraph

namespace ros {
namespace message_traits {

template <>
struct IsMessage<sgraph::Cloud> : TrueType {};
template <>
struct IsMessage<const sgraph::Cloud> : TrueType {};
template <>
struct HasHeader<sgraph::Cloud> : TrueType {};  // on the wire: roscpp counts its sequence number up

template <>
struct MD5Sum<sgraph::Cloud> : MD5Sum<sensor_msgs::PointCloud2> {
  static const char* value(const sgraph::Cloud&) { return MD5Sum<sensor_msgs::PointCloud2>::value(); }
  using MD5Sum<sensor_msgs::PointCloud2>::value;
};
template <>
struct DataType<sgraph::Cloud> : DataType<sensor_msgs::PointCloud2> {
  static const char* value(const sgraph::Cloud&) { return DataType<sensor_msgs::PointCloud2>::value(); }
  using DataType<sensor_msgs::PointCloud2>::value;
};
template <>
struct Definition<sgraph::Cloud> : Definition<sensor_msgs::PointCloud2> {
  static const char* value(const sgraph::Cloud&) { return Definition<sensor_msgs::PointCloud2>::value(); }
  using Definition<sensor_msgs::PointCloud2>::value;
};

template <>
struct TimeStamp<sgraph::Cloud, void> {
  static ros::Time value(const sgraph::Cloud& cloud) { return sgraph::to_ros_time(cloud.stamp); }
};
template <>
struct FrameId<sgraph::Cloud, void> {
  static std::string value(const sgraph::Cloud& cloud) { return cloud.frame; }
};

}  // namespace message_traits

namespace serialization {

template <>
struct Serializer<sgraph::Cloud> {
  static void write(OStream& stream, const sgraph::Cloud& cloud);
  /// Takes any layout that has x, y and z; throws std::runtime_error for another cloud, and roscpp drops the message with that text.
  static void read(IStream& stream, sgraph::Cloud& cloud);
  static std::uint32_t serializedLength(const sgraph::Cloud& cloud);
};

}  // namespace serialization
}  // namespace ros
