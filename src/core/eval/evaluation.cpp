#include "sgraph_slam/core/eval/evaluation.hpp"

namespace sgraph {

TrajectoryEvaluation evaluate_trajectory(const Trajectory& estimate, const Trajectory& truth) {
  TrajectoryEvaluation e;
  e.poses = static_cast<int>(estimate.size());
  e.pose_pairs = pair_by_stamp(estimate, truth);
  e.pairs = static_cast<int>(e.pose_pairs.size());
  e.T_truth_estimate = align(e.pose_pairs);
  e.errors = absolute_errors(e.pose_pairs, e.T_truth_estimate);
  e.absolute = statistics_of(e.errors);
  e.relative = statistics_of(relative_errors(e.pose_pairs));
  e.drift = drift(e.pose_pairs);
  e.start_to_end = start_to_end_error(e.pose_pairs);
  e.length = path_length(e.pose_pairs);
  e.duration = e.pose_pairs.back().stamp - e.pose_pairs.front().stamp;
  return e;
}

}  // namespace sgraph
