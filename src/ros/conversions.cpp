#include "sgraph_slam/ros/conversions.hpp"

#include <cmath>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

Converted<Pose> pose_from(const Eigen::Vector3d& translation, const Eigen::Quaterniond& rotation) {
  if (!translation.allFinite() || !rotation.coeffs().allFinite()) return {{}, MessageFault::not_finite, "the pose is not finite"};
  if (std::abs(rotation.norm() - 1) > 0.01) {
    return {{}, MessageFault::quaternion, "the rotation's quaternion has the length " + std::to_string(rotation.norm())};
  }
  return {{rotation.normalized(), translation}, MessageFault::none, ""};
}

}  // namespace

const char* to_string(MessageFault value) {
  switch (value) {
    case MessageFault::none: return "none";
    case MessageFault::missing_field: return "missing_field";
    case MessageFault::field_type: return "field_type";
    case MessageFault::layout: return "layout";
    case MessageFault::big_endian: return "big_endian";
    case MessageFault::times: return "times";
    case MessageFault::beams: return "beams";
    case MessageFault::frame: return "frame";
    case MessageFault::stamp: return "stamp";
    case MessageFault::not_finite: return "not_finite";
    case MessageFault::quaternion: break;
  }
  return "quaternion";
}

Stamp to_stamp(const ros::Time& time) { return {std::int64_t{time.sec} * 1'000'000'000 + time.nsec}; }

ros::Time to_ros_time(Stamp stamp) { return ros::Time().fromNSec(static_cast<std::uint64_t>(stamp.nanoseconds)); }

Converted<ImuSample> to_imu_sample(const sensor_msgs::Imu& message, const Eigen::Quaterniond& R_base_imu) {
  const Eigen::Vector3d rate(message.angular_velocity.x, message.angular_velocity.y, message.angular_velocity.z);
  const Eigen::Vector3d force(message.linear_acceleration.x, message.linear_acceleration.y, message.linear_acceleration.z);
  if (!rate.allFinite() || !force.allFinite()) return {{}, MessageFault::not_finite, "the inertial reading is not finite"};
  return {{to_stamp(message.header.stamp), R_base_imu * rate, R_base_imu * force}, MessageFault::none, ""};
}

Converted<OdometrySample> to_odometry_sample(const nav_msgs::Odometry& message) {
  const auto& p = message.pose.pose.position;
  const auto& q = message.pose.pose.orientation;
  const auto pose = pose_from({p.x, p.y, p.z}, {q.w, q.x, q.y, q.z});
  if (!pose) return {{}, pose.fault, pose.text};

  OdometrySample sample{to_stamp(message.header.stamp), pose.value, Matrix6::Zero()};
  const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> given(message.pose.covariance.data());  // translation, rotation
  if (given.allFinite() && (given.diagonal().array() >= 0).all()) {
    sample.covariance.topLeftCorner<3, 3>() = given.bottomRightCorner<3, 3>();
    sample.covariance.topRightCorner<3, 3>() = given.bottomLeftCorner<3, 3>();
    sample.covariance.bottomLeftCorner<3, 3>() = given.topRightCorner<3, 3>();
    sample.covariance.bottomRightCorner<3, 3>() = given.topLeftCorner<3, 3>();
  }
  return {sample, MessageFault::none, ""};
}

OdometrySample moved_along_body(const OdometrySample& sample, const Pose& T_child_base) {
  OdometrySample moved = sample;
  moved.T_odom_base = sample.T_odom_base * T_child_base;
  // A small turn about the odometry's axes also shifts what sits at the end of the lever.
  Matrix6 jacobian = Matrix6::Identity();
  jacobian.bottomLeftCorner<3, 3>() = -skew(sample.T_odom_base.rotation * T_child_base.translation);
  moved.covariance = jacobian * sample.covariance * jacobian.transpose();
  return moved;
}

Converted<Pose> to_pose(const geometry_msgs::Transform& transform) {
  const auto& t = transform.translation;
  const auto& q = transform.rotation;
  return pose_from({t.x, t.y, t.z}, {q.w, q.x, q.y, q.z});
}

std::string frame_name(const std::string& frame_id) { return !frame_id.empty() && frame_id.front() == '/' ? frame_id.substr(1) : frame_id; }

}  // namespace sgraph
