#pragma once

#include <optional>
#include <string>

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Transform.h>
#include <nav_msgs/Odometry.h>
#include <sgraph_slam/Keyframe.h>
#include <sgraph_slam/OdometryStatus.h>
#include <sgraph_slam/PlaneSegments.h>
#include <sgraph_slam/SceneGraph.h>

#include "sgraph_slam/core/odometry/odometry.hpp"
#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/scene.hpp"
#include "sgraph_slam/core/types/segments.hpp"

/// Values of the core <-> messages. Numbers are copied as they are (doubles on both sides), so that what has travelled equals what was sent. What
/// comes in is checked: a message with a number that isn't finite, a quaternion or normal that isn't a unit, a covariance that isn't one or a list of
/// the wrong length gives nothing.

namespace sgraph {

geometry_msgs::Pose to_message(const Pose& pose);
geometry_msgs::Transform to_transform(const Pose& pose);
std::optional<Pose> from_message(const geometry_msgs::Pose& message);

/// The keyframe without its cloud, which travels on a topic of its own. `T_base_lidar` is what the odometry used.
sgraph_slam::Keyframe to_message(const Keyframe& keyframe, const Pose& T_base_lidar, const std::string& odom_frame, const std::string& base_frame);

struct ReceivedKeyframe {
  Keyframe keyframe;  ///< without its cloud
  Pose T_base_lidar;
  std::string odom_frame;
  std::string base_frame;
};
std::optional<ReceivedKeyframe> from_message(const sgraph_slam::Keyframe& message);

sgraph_slam::PlaneSegments to_message(const PlaneSegments& segments, const std::string& lidar_frame);
std::optional<PlaneSegments> from_message(const sgraph_slam::PlaneSegments& message);

/// How the scan of this stamp went.
sgraph_slam::OdometryStatus to_status_message(ScanVerdict verdict, const OdometryEstimate& estimate, const std::string& odom_frame);
/// The part of the estimate that the status tells (no pose); nothing for a refused scan.
std::optional<OdometryEstimate> from_message(const sgraph_slam::OdometryStatus& message);

/// The live estimate for the ROS world. nav_msgs/Odometry wants the pose's covariance about the fixed axes of the odometry frame, translation first;
/// ours is about the base's axes, rotation first. The twist's covariance is left at zero: unknown.
nav_msgs::Odometry to_odometry_message(const OdometryEstimate& estimate, const std::string& odom_frame, const std::string& base_frame);

/// All layers. What only the back end needs (clouds, the scans within keyframes, factors) stays out.
sgraph_slam::SceneGraph to_message(const GraphSnapshot& snapshot);
std::optional<GraphSnapshot> from_message(const sgraph_slam::SceneGraph& message);

}  // namespace sgraph
