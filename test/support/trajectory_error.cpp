#include "trajectory_error.hpp"

#include <algorithm>

#include "sgraph_slam/core/eval/evaluation.hpp"
#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph::test {

double worst_error(const Trajectory& estimate, const Trajectory& truth) {
  double worst = 0;
  for (const StampedPose& p : estimate) {
    const Pose expected = pose_at(truth, estimate.front().stamp).inverse() * pose_at(truth, p.stamp);
    worst = std::max(worst, (expected.translation - (estimate.front().pose.inverse() * p.pose).translation).norm());
  }
  return worst;
}

double ate(const Trajectory& estimate, const Trajectory& truth) { return evaluate_trajectory(estimate, truth).absolute.translation.rmse; }

}  // namespace sgraph::test
