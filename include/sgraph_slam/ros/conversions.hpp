#pragma once

#include <geometry_msgs/Transform.h>
#include <nav_msgs/Odometry.h>
#include <ros/time.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud2.h>

#include <optional>
#include <string>

#include "sgraph_slam/core/sensor/raw_scan.hpp"
#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/pose.hpp"
#include "sgraph_slam/core/types/sensor.hpp"

namespace sgraph {

/// Why a message is of no use.
enum class MessageFault {
  none,
  missing_field,  ///< a cloud without x, y or z
  field_type,     ///< a field of a type that can't hold what its name says
  layout,         ///< steps, offsets and sizes that contradict each other or the data
  big_endian,     ///< a cloud in the other byte order
  times,          ///< per-point times that have nothing to do with the cloud's stamp
  beams,          ///< points that lie on none of the sensor's beams: the data isn't what the fields say
  frame,          ///< a cloud of another frame than the others, or of none
  stamp,          ///< zero, far from the time of recording, or a scan's far ahead of those after it
  not_finite,     ///< NaN or infinite where a pose or a reading should be
  quaternion,     ///< a rotation whose quaternion is not of length 1
};

const char* to_string(MessageFault value);

/// A converted message, or why it couldn't be converted, with a sentence for the log.
template <class T>
struct Converted {
  T value{};
  MessageFault fault = MessageFault::none;
  std::string text;

  explicit operator bool() const { return fault == MessageFault::none; }
};

/// Exact both ways.
Stamp to_stamp(const ros::Time& time);
ros::Time to_ros_time(Stamp stamp);

/// A cloud from any driver's message, its fields found by name in *this* message (a bag or a topic may change its layout):
/// - x, y, z: float32 or float64;
/// - intensity: any number; ring: uint8, uint16 or uint32;
/// - time of each point: `time` (seconds from the stamp; Velodyne), `t` (nanoseconds from the stamp when an integer, else seconds; Ouster), or
///   `timestamp` (absolute, float64; Hesai, RoboSense).
/// A missing intensity, ring or time is 0. Organised clouds are taken row by row; points that are NaN are kept.
Converted<CloudPtr> to_cloud(const sensor_msgs::PointCloud2& message);

/// The same cloud with its times as the field holds them, for the SensorAdapter to recognise. `received`: when the message was recorded.
Converted<RawScan> to_raw_scan(const sensor_msgs::PointCloud2& message, const std::optional<ros::Time>& received = std::nullopt);

/// `R_base_imu` turns the unit's axes into the base's. The lever arm between the two is not taken out of the acceleration.
Converted<ImuSample> to_imu_sample(const sensor_msgs::Imu& message, const Eigen::Quaterniond& R_base_imu);

/// The pose of the message's child frame, with the covariance of its rotation and translation (that order, ROS's fixed axes: those of the odometry's
/// frame); zero when the message gives none, or one with negative or infinite variances.
Converted<OdometrySample> to_odometry_sample(const nav_msgs::Odometry& message);

/// The pose of another frame that is fixed to the same body, with its covariance: `T_child_base` is where the base is in the frame whose pose the
/// sample holds.
OdometrySample moved_along_body(const OdometrySample& sample, const Pose& T_child_base);

/// `T_parent_child` of a tf transform.
Converted<Pose> to_pose(const geometry_msgs::Transform& transform);

/// Frame names as tf2 has them: without the leading slash of old drivers.
std::string frame_name(const std::string& frame_id);

}  // namespace sgraph
