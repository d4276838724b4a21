#include "message_parts.hpp"
#include "sgraph_slam/ros/conversions.hpp"
#include "sgraph_slam/ros/messages.hpp"

namespace sgraph {

sgraph_slam::OdometryStatus to_status_message(ScanVerdict verdict, const OdometryEstimate& estimate, const std::string& odom_frame) {
  sgraph_slam::OdometryStatus message;
  message.header.stamp = to_ros_time(estimate.stamp);
  message.header.frame_id = odom_frame;
  message.accepted = verdict == ScanVerdict::accepted;
  message.verdict = to_string(verdict);
  if (!message.accepted) return message;
  message.status = static_cast<std::uint8_t>(estimate.status);
  message.inlier_share = estimate.inlier_share;
  message.residual_rms = estimate.residual_rms;
  message.keypoints = estimate.keypoints;
  message.iterations = estimate.iterations;
  message.degenerate = to_twists(estimate.degenerate);
  return message;
}

static_assert(sgraph_slam::OdometryStatus::STARTED == static_cast<int>(OdometryStatus::started));
static_assert(sgraph_slam::OdometryStatus::TRACKED == static_cast<int>(OdometryStatus::tracked));
static_assert(sgraph_slam::OdometryStatus::PREDICTED == static_cast<int>(OdometryStatus::predicted));
static_assert(sgraph_slam::OdometryStatus::EXTERNAL == static_cast<int>(OdometryStatus::external));

std::optional<OdometryEstimate> from_message(const sgraph_slam::OdometryStatus& message) {
  if (!message.accepted || message.status > sgraph_slam::OdometryStatus::EXTERNAL) return {};
  OdometryEstimate estimate;
  estimate.stamp = to_stamp(message.header.stamp);
  estimate.status = static_cast<OdometryStatus>(message.status);
  estimate.inlier_share = message.inlier_share;
  estimate.residual_rms = message.residual_rms;
  estimate.keypoints = message.keypoints;
  estimate.iterations = message.iterations;
  estimate.degenerate = directions_of(message.degenerate);
  if (!std::isfinite(estimate.inlier_share) || !std::isfinite(estimate.residual_rms) || !finite(estimate.degenerate)) return {};
  return estimate;
}

}  // namespace sgraph
