#pragma once

#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/odometry/motion.hpp"
#include "sgraph_slam/core/odometry/robot_params.hpp"
#include "sgraph_slam/core/registration/rigid_alignment.hpp"

namespace sgraph {

/// Time [s] between scans after which a motion predicted from the last one means little.
constexpr double long_gap = 0.3;

/// Where the sensor was when a scan was last accepted, for a scan that ends at `time`.
struct LastKnown {
  Knot knot;           ///< LiDAR in odom
  double time = 0;     ///< [s], of the knots' clock
  Eigen::Vector3d up;  ///< in odom, |up| = 1

  [[nodiscard]] double lost_for() const { return time - knot.time; }
};

/// Whether the robot can have needed the correction, and have come to `now` [LiDAR in odom], since then. Robots that walk or drive stay on the floor:
/// their height and tilt change little.
bool plausible(const RobotParams& robot, const LastKnown& known, const RigidAlignmentResult& alignment, const Pose& now);

/// Corrections of the prediction to try when it is far off: the predicted motion or none since the last scan (`held`), each set upright by `upright`
/// and turned to the left and right, the further the longer nothing was accepted.
std::vector<Pose> other_starts(const LastKnown& known, const Pose& predicted, const Pose& held, const Eigen::Quaterniond& upright);

}  // namespace sgraph
