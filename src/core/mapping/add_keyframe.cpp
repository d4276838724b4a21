#include "sgraph_slam/core/mapping/add_keyframe.hpp"

#include <cmath>

#include <Eigen/Eigenvalues>

#include "sgraph_slam/core/graph/committer.hpp"

namespace sgraph {
namespace {

Matrix6 floored(Matrix6 covariance, const Keyframe& keyframe, const FactorParams& params) {
  const double angle = params.keyframe_floor_angle;
  const double distance = params.keyframe_floor_distance;
  covariance.diagonal().head<3>().array() += angle * angle;
  covariance.diagonal().tail<3>().array() += distance * distance;
  for (const Vector6& v : keyframe.degenerate) {
    const double sigma = std::hypot(v.head<3>().norm() * params.degenerate_angle, v.tail<3>().norm() * params.degenerate_distance);
    covariance += sigma * sigma * v * v.transpose();
  }
  return covariance;
}

bool finite(const Pose& pose) {
  return pose.rotation.coeffs().allFinite() && pose.translation.allFinite() && std::abs(pose.rotation.norm() - 1) < 1e-6;
}

}  // namespace

bool is_ride(const Pose& base, const Matrix6& covariance) {
  constexpr double unknown = 3.0;    // [m]
  constexpr double known = 0.3;      // [m]
  constexpr double upright = 0.996;  // 5 degrees
  const Eigen::Matrix3d c = covariance.bottomRightCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(c);
  return axes.eigenvalues()[2] > unknown * unknown && axes.eigenvalues()[1] < known * known &&
         std::abs((base.rotation * axes.eigenvectors().col(2)).z()) > upright;
}

bool add_keyframe(MapState& state, const Keyframe& keyframe, const KeyframeCloud& cloud) {
  Committer committer{state.graph, state.log};
  const auto refuse = [&](const char* reason) {
    committer.note(false, "keyframe/" + std::to_string(keyframe.id.value), reason);
    return false;
  };
  const bool measured_well = !keyframe.measured || (finite(keyframe.measured->T_last_now) && keyframe.measured->covariance.allFinite());
  if (!finite(keyframe.T_odom_base) || !keyframe.covariance.allFinite() || !measured_well) return refuse("not finite");
  if (!keyframe.id.valid() || (!state.keyframes.empty() && !(committer.newest() < keyframe.id))) return refuse("not newer than the last");
  const Pose claimed = state.keyframes.empty() ? Pose{} : state.keyframes.rbegin()->second.T_odom_base.inverse() * keyframe.T_odom_base;
  const KeyframeMotion motion = keyframe.measured.value_or(KeyframeMotion{claimed, keyframe.covariance});
  const Matrix6 covariance = floored(motion.covariance, keyframe, state.params.factors);
  Transaction edit;
  edit.reason = "keyframe/" + std::to_string(keyframe.id.value);
  if (state.keyframes.empty()) {
    edit.keyframes[keyframe.id] = state.T_map_odom * keyframe.T_odom_base;
  } else {
    const SceneKeyframe& last = state.keyframes.rbegin()->second;
    edit.keyframes[keyframe.id] = *state.graph.find(last.id) * motion.T_last_now;
    Vector6 tiny;
    tiny << Eigen::Vector3d::Constant(1e-6), Eigen::Vector3d::Constant(1e-6);
    add_factor(edit, Se3Between{last.id, keyframe.id, motion.T_last_now, SqrtInformation<6>::from_covariance(covariance, tiny),
                                Se3Between::Source::odometry});
  }
  if (!committer.commit(edit).ok()) return false;
  if (!state.keyframes.empty() && is_ride(keyframe.T_odom_base, motion.covariance)) state.rides.push_back({keyframe.id});
  state.planes.drift.add(keyframe.id, keyframe.T_odom_base, covariance);
  state.keyframes[keyframe.id] = {keyframe.id, keyframe.stamp, *state.graph.find(keyframe.id), keyframe.T_odom_base, keyframe.scans, cloud};
  return true;
}

}  // namespace sgraph
