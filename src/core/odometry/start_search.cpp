#include "sgraph_slam/core/odometry/start_search.hpp"

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

constexpr double searched_turn = 1.5;      // [rad/s] to either side,
constexpr int fewest_turns = 9;            // at least this many
constexpr int most_turns = 31;             // and at most this many
constexpr double turn_step = 0.1;          // [rad] of these
constexpr double some_rotation = 0.1;      // [rad], and
constexpr double some_translation = 0.15;  // [m] that a correction may always have
constexpr double fastest_turn = 4.0;       // [rad/s], and
constexpr double fastest_way = 3.0;        // [m/s]: motions, and changes of the motion, beyond which a result is not believed
constexpr double step_up = 0.15;           // [m] of height, and
constexpr double tilt_at_once = 0.15;      // [rad] of tilt that anything may change by between two scans, and
constexpr double fastest_climb = 0.5;      // [m/s], and
constexpr double fastest_tilt = 1.0;       // [rad/s]: what robots and people add to that as time goes by,
constexpr double widest_tilt = 0.4;        // [rad] at most

}  // namespace

bool plausible(const LastKnown& known, const RigidAlignmentResult& alignment, const Pose& now) {
  const double blind = known.blind();
  const Pose& before = known.knot.pose;
  const Eigen::Vector3d turned = now.rotation * (before.rotation.conjugate() * known.up);
  const double tilt = std::acos(std::clamp(turned.dot(known.up), -1.0, 1.0));
  const double most_tilt = std::min(tilt_at_once + fastest_tilt * blind, widest_tilt);
  const Eigen::Vector3d way = now.translation - before.translation;
  return alignment.rotation < some_rotation + fastest_turn * blind && alignment.translation < some_translation + fastest_way * blind &&
         way.norm() < some_translation + fastest_way * blind && tilt < most_tilt && std::abs(way.dot(known.up)) < step_up + fastest_climb * blind;
}

std::vector<Pose> other_starts(const LastKnown& known, const Pose& predicted, const Pose& held, const Eigen::Quaterniond& upright) {
  const int steps = std::clamp(static_cast<int>(std::ceil(searched_turn * known.blind() / turn_step)), fewest_turns, most_turns);
  std::vector<Pose> starts;
  for (const Pose& base : {predicted, held}) {
    for (int i = -steps; i <= steps; ++i) {
      const Pose turned{so3_exp(i * turn_step * known.up) * upright * base.rotation, base.translation};
      starts.push_back(turned * predicted.inverse());
    }
  }
  return starts;
}

}  // namespace sgraph
