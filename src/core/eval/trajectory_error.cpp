#include "sgraph_slam/core/eval/trajectory_error.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/SVD>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

constexpr double degrees = 180 / M_PI;

std::size_t nearest_in_time(const Trajectory& trajectory, Stamp stamp) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), stamp, [](const StampedPose& p, Stamp s) { return p.stamp < s; });
  if (after == trajectory.begin()) return 0;
  const auto index = static_cast<std::size_t>(after - trajectory.begin());
  if (after == trajectory.end()) return index - 1;
  return stamp - trajectory[index - 1].stamp <= after->stamp - stamp ? index - 1 : index;
}

// Error of the estimated motion from pair i to pair k, seen from the true end.
PoseError motion_error(const PosePair& i, const PosePair& k) {
  const Pose moved = i.estimate.inverse() * k.estimate;
  const Pose truly = i.truth.inverse() * k.truth;
  const Pose error = truly.inverse() * moved;
  return {error.translation.norm(), rotation_angle(truly.rotation, moved.rotation)};
}

}  // namespace

std::vector<PosePair> pair_by_stamp(const Trajectory& estimate, const Trajectory& truth, double max_difference) {
  std::vector<PosePair> pairs;
  if (estimate.empty() || truth.empty()) return pairs;
  const bool estimate_is_longer = estimate.size() > truth.size();
  const Trajectory& shorter = estimate_is_longer ? truth : estimate;
  const Trajectory& longer = estimate_is_longer ? estimate : truth;
  for (const StampedPose& s : shorter) {
    const StampedPose& l = longer[nearest_in_time(longer, s.stamp)];
    if (std::abs(l.stamp - s.stamp) > max_difference) continue;
    const StampedPose& e = estimate_is_longer ? l : s;
    const StampedPose& t = estimate_is_longer ? s : l;
    pairs.push_back({e.stamp, e.pose, t.pose});
  }
  return pairs;
}

Pose align(const std::vector<PosePair>& pairs) {
  if (pairs.empty()) throw std::runtime_error("no estimated pose has a true one of its time");
  const auto n = static_cast<double>(pairs.size());
  Eigen::Vector3d mean_e = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_t = Eigen::Vector3d::Zero();
  for (const PosePair& p : pairs) mean_e += p.estimate.translation / n, mean_t += p.truth.translation / n;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const PosePair& p : pairs) covariance += (p.truth.translation - mean_t) * (p.estimate.translation - mean_e).transpose() / n;

  Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (svd.singularValues()[1] < 1e-6) {
    // Standing still, or on a straight line to within a millimetre: the positions don't hold the rotation, so let the orientations in.
    for (const PosePair& p : pairs) covariance += 1e-6 / n * p.truth.matrix() * p.estimate.matrix().transpose();
    svd.compute(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  }
  Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) mirror(2, 2) = -1;
  Pose T;
  T.rotation = Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * mirror * svd.matrixV().transpose())).normalized();
  T.translation = mean_t - T.rotation * mean_e;
  return T;
}

PoseErrorStatistics statistics_of(const std::vector<PoseError>& errors) {
  std::vector<double> translations;
  std::vector<double> rotations;
  for (const PoseError& e : errors) translations.push_back(e.translation), rotations.push_back(e.rotation * degrees);
  return {statistics_of(std::move(translations)), statistics_of(std::move(rotations))};
}

std::vector<PoseError> absolute_errors(const std::vector<PosePair>& pairs, const Pose& T_truth_estimate) {
  std::vector<PoseError> errors;
  errors.reserve(pairs.size());
  for (const PosePair& p : pairs) {
    const Pose aligned = T_truth_estimate * p.estimate;
    errors.push_back({(aligned.translation - p.truth.translation).norm(), rotation_angle(p.truth.rotation, aligned.rotation)});
  }
  return errors;
}

std::vector<PoseError> relative_errors(const std::vector<PosePair>& pairs, double length) {
  std::vector<PoseError> errors;
  const PosePair* begin = nullptr;
  double path = 0;
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    path += (pairs[i].estimate.translation - pairs[i - 1].estimate.translation).norm();
    if (path < length) continue;
    if (begin) errors.push_back(motion_error(*begin, pairs[i]));
    begin = &pairs[i];
    path = 0;
  }
  return errors;
}

Drift drift(const std::vector<PosePair>& pairs, double length) {
  std::vector<double> path(pairs.size(), 0);
  for (std::size_t i = 1; i < pairs.size(); ++i) path[i] = path[i - 1] + (pairs[i].truth.translation - pairs[i - 1].truth.translation).norm();
  Drift result;
  for (std::size_t first = 0; first < pairs.size();) {
    const auto last = std::lower_bound(path.begin() + static_cast<std::ptrdiff_t>(first), path.end(), path[first] + length);
    if (last == path.end()) break;
    const PoseError e = motion_error(pairs[first], pairs[static_cast<std::size_t>(last - path.begin())]);
    ++result.segments;
    result.translation_percent += 100 * e.translation / length;
    result.rotation_deg_per_m += e.rotation * degrees / length;
    const Stamp next = pairs[first].stamp.after(1);
    while (first < pairs.size() && pairs[first].stamp < next) ++first;
  }
  if (result.segments > 0) result.translation_percent /= result.segments, result.rotation_deg_per_m /= result.segments;
  return result;
}

PoseError start_to_end_error(const std::vector<PosePair>& pairs) { return pairs.empty() ? PoseError{} : motion_error(pairs.front(), pairs.back()); }

double path_length(const std::vector<PosePair>& pairs) {
  double length = 0;
  for (std::size_t i = 1; i < pairs.size(); ++i) length += (pairs[i].truth.translation - pairs[i - 1].truth.translation).norm();
  return length;
}

}  // namespace sgraph
