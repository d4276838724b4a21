#include "sgraph_slam/core/odometry/start_search.hpp"

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

constexpr double searched_rotation = 1.5;  // [rad/s] to either side,
constexpr int fewest_rotations = 9;        // at least this many
constexpr int most_rotations = 31;         // and at most this many
constexpr double rotation_step = 0.1;      // [rad] of these
constexpr double some_rotation = 0.1;      // [rad], and
constexpr double some_translation = 0.15;  // [m] that a correction may always have
constexpr double tilt_at_once = 0.15;      // [rad] that anything may tilt by between two scans

}  // namespace

bool plausible(const RobotParams& robot, const LastKnown& known, const RigidAlignmentResult& alignment, const Pose& now) {
  const double lost_for = known.lost_for();
  const Pose& before = known.knot.pose;
  const Eigen::Vector3d turned = now.rotation * (before.rotation.conjugate() * known.up);
  const double tilt = std::acos(std::clamp(turned.dot(known.up), -1.0, 1.0));
  const double most_tilt = std::min(tilt_at_once + robot.tilt_rate * lost_for, robot.tilt);
  const Eigen::Vector3d translation = now.translation - before.translation;
  return alignment.rotation < some_rotation + robot.turn_rate * lost_for && alignment.translation < some_translation + robot.speed * lost_for &&
         translation.norm() < some_translation + robot.speed * lost_for && tilt < most_tilt &&
         std::abs(translation.dot(known.up)) < robot.step + robot.climb_rate * lost_for;
}

std::vector<Pose> other_starts(const LastKnown& known, const Pose& predicted, const Pose& held, const Eigen::Quaterniond& upright) {
  const int steps = std::clamp(static_cast<int>(std::ceil(searched_rotation * known.lost_for() / rotation_step)), fewest_rotations, most_rotations);
  std::vector<Pose> starts;
  for (const Pose& base : {predicted, held}) {
    for (int i = -steps; i <= steps; ++i) {
      const Pose turned{so3_exp(i * rotation_step * known.up) * upright * base.rotation, base.translation};
      starts.push_back(turned * predicted.inverse());
    }
  }
  return starts;
}

}  // namespace sgraph
