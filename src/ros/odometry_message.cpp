#include "message_parts.hpp"
#include "sgraph_slam/ros/conversions.hpp"
#include "sgraph_slam/ros/messages.hpp"

namespace sgraph {

nav_msgs::Odometry to_odometry_message(const OdometryEstimate& estimate, const std::string& odom_frame, const std::string& base_frame) {
  nav_msgs::Odometry message;
  message.header.stamp = to_ros_time(estimate.stamp);
  message.header.frame_id = odom_frame;
  message.child_frame_id = base_frame;
  message.pose.pose = to_message(estimate.T_odom_base);
  // [dt; dtheta] about the fixed axes = A [phi; v] about the base's.
  const Eigen::Matrix3d R = estimate.T_odom_base.matrix();
  Matrix6 A = Matrix6::Zero();
  A.topRightCorner<3, 3>() = R;
  A.bottomLeftCorner<3, 3>() = R;
  to_rows<6>(A * estimate.covariance * A.transpose(), message.pose.covariance);
  message.twist.twist.angular = to_vector(estimate.twist.head<3>());
  message.twist.twist.linear = to_vector(estimate.twist.tail<3>());
  return message;
}

}  // namespace sgraph
