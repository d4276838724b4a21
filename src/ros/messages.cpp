#include "sgraph_slam/ros/messages.hpp"

#include <cmath>

#include "message_parts.hpp"
#include "sgraph_slam/ros/conversions.hpp"

namespace sgraph {

namespace {

std::optional<Trajectory> trajectory_of(const std::vector<sgraph_slam::StampedPose>& messages) {
  Trajectory trajectory;
  trajectory.reserve(messages.size());
  for (const sgraph_slam::StampedPose& message : messages) {
    const std::optional<Pose> pose = from_message(message.pose);
    if (!pose) return {};
    trajectory.push_back({to_stamp(message.stamp), *pose});
  }
  return trajectory;
}

bool is_covariance(const Matrix6& m) { return m.allFinite() && (m.diagonal().array() >= 0).all(); }

}  // namespace

geometry_msgs::Pose to_message(const Pose& pose) {
  geometry_msgs::Pose message;
  message.position = to_point(pose.translation);
  message.orientation.x = pose.rotation.x();
  message.orientation.y = pose.rotation.y();
  message.orientation.z = pose.rotation.z();
  message.orientation.w = pose.rotation.w();
  return message;
}

geometry_msgs::Transform to_transform(const Pose& pose) {
  geometry_msgs::Transform message;
  message.translation = to_vector(pose.translation);
  message.rotation = to_message(pose).orientation;
  return message;
}

std::optional<Pose> from_message(const geometry_msgs::Pose& message) {
  const geometry_msgs::Quaternion& q = message.orientation;
  const Pose pose{Eigen::Quaterniond(q.w, q.x, q.y, q.z), vector_of(message.position)};
  const bool good = pose.translation.allFinite() && std::abs(pose.rotation.norm() - 1) < unit_tolerance;  // false for NaN
  return good ? std::optional(pose) : std::nullopt;
}

sgraph_slam::Keyframe to_message(const Keyframe& keyframe, const Pose& T_base_lidar, const std::string& odom_frame, const std::string& base_frame) {
  sgraph_slam::Keyframe message;
  message.header.stamp = to_ros_time(keyframe.stamp);
  message.header.frame_id = odom_frame;
  message.id = keyframe.id.value;
  message.base_frame = base_frame;
  message.pose = to_message(keyframe.T_odom_base);
  message.base_to_lidar = to_message(T_base_lidar);
  to_rows<6>(keyframe.covariance, message.covariance);
  message.degenerate = to_twists(keyframe.degenerate);
  message.measured = keyframe.measured.has_value();
  message.motion = to_message(keyframe.measured ? keyframe.measured->T_last_now : Pose{});
  if (keyframe.measured) to_rows<6>(keyframe.measured->covariance, message.motion_covariance);
  message.ridden = static_cast<std::uint8_t>(keyframe.ride.has_value());
  message.rise = keyframe.ride ? keyframe.ride->height : 0;
  message.rise_sigma = keyframe.ride ? keyframe.ride->sigma : 0;
  message.scans.resize(keyframe.scans.size());
  for (std::size_t i = 0; i < keyframe.scans.size(); ++i) {
    message.scans[i].stamp = to_ros_time(keyframe.scans[i].stamp);
    message.scans[i].pose = to_message(keyframe.scans[i].pose);
  }
  return message;
}

std::optional<ReceivedKeyframe> from_message(const sgraph_slam::Keyframe& message) {
  const std::optional<Pose> pose = from_message(message.pose);
  const std::optional<Pose> T_base_lidar = from_message(message.base_to_lidar);
  std::optional<Trajectory> scans = trajectory_of(message.scans);
  if (!pose || !T_base_lidar || !scans) return {};

  ReceivedKeyframe received;
  received.T_base_lidar = *T_base_lidar;
  received.odom_frame = message.header.frame_id;
  received.base_frame = message.base_frame;
  Keyframe& keyframe = received.keyframe;
  keyframe.id = {message.id};
  keyframe.stamp = to_stamp(message.header.stamp);
  keyframe.T_odom_base = *pose;
  keyframe.covariance = from_rows<6>(message.covariance);
  keyframe.degenerate = directions_of(message.degenerate);
  keyframe.scans = std::move(*scans);
  if (message.ridden != 0) keyframe.ride = Rise{message.rise, message.rise_sigma};
  const bool rise_good = !keyframe.ride || (std::isfinite(message.rise) && message.rise_sigma > 0);  // NaN isn't
  bool good = rise_good && keyframe.id.valid() && is_covariance(keyframe.covariance) && finite(keyframe.degenerate);
  if (message.measured) {
    const std::optional<Pose> motion = from_message(message.motion);
    if (!motion) return {};
    keyframe.measured = KeyframeMotion{*motion, from_rows<6>(message.motion_covariance)};
    good = good && is_covariance(keyframe.measured->covariance);
  }
  return good ? std::optional(std::move(received)) : std::nullopt;
}

sgraph_slam::PlaneSegments to_message(const PlaneSegments& segments, const std::string& lidar_frame) {
  sgraph_slam::PlaneSegments message;
  message.header.stamp = to_ros_time(segments.stamp);
  message.header.frame_id = lidar_frame;
  message.segments.resize(segments.segments.size());
  for (std::size_t i = 0; i < segments.segments.size(); ++i) {
    const PlaneSegment& segment = segments.segments[i];
    sgraph_slam::PlaneSegment& target = message.segments[i];
    target.normal = to_vector(segment.plane.normal);
    target.d = segment.plane.d;
    to_rows<3>(segment.covariance, target.covariance);
    to_rows<4>(segment.scatter, target.scatter);
    target.sigma = segment.sigma;
    target.count = segment.count;
    target.centroid = to_point(segment.centroid);
    target.extent = to_points(segment.extent);
  }
  return message;
}

std::optional<PlaneSegments> from_message(const sgraph_slam::PlaneSegments& message) {
  PlaneSegments segments;
  segments.stamp = to_stamp(message.header.stamp);
  segments.segments.reserve(message.segments.size());
  for (const sgraph_slam::PlaneSegment& source : message.segments) {
    PlaneSegment segment;
    segment.plane = {vector_of(source.normal), source.d};
    segment.covariance = from_rows<3>(source.covariance);
    segment.scatter = from_rows<4>(source.scatter);
    segment.sigma = source.sigma;
    segment.count = source.count;
    segment.centroid = vector_of(source.centroid);
    segment.extent = points_of(source.extent);
    const bool numbers = std::isfinite(segment.plane.d) && segment.covariance.allFinite() && segment.scatter.allFinite() &&
                         std::isfinite(segment.sigma) && segment.centroid.allFinite() && finite(segment.extent);
    if (!numbers || !is_unit(segment.plane.normal) || segment.count < 0) return {};
    segments.segments.push_back(std::move(segment));
  }
  return segments;
}

}  // namespace sgraph
