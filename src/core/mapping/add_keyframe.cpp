#include "sgraph_slam/core/mapping/add_keyframe.hpp"

#include <cmath>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/planes/level_floors.hpp"

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
  KeyframeMotion motion = keyframe.measured.value_or(KeyframeMotion{claimed, keyframe.covariance});
  // As far as is known: floors hold the height (`lift_floors`), for in a cabin nothing that is seen holds the sensor above its floor.
  if (keyframe.ride && !state.keyframes.empty()) {
    const SceneKeyframe& last = state.keyframes.rbegin()->second;
    const auto floor = largest_floor(state.graph, state.planes.map, last.storey);  // straight up: the map's z is that of the first pose
    const Eigen::Vector3d up = floor ? state.graph.find(*floor)->normal : Eigen::Vector3d::UnitZ();
    motion.T_last_now.translation += keyframe.ride->height * (state.graph.find(last.id)->rotation.conjugate() * up);
  }
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
                                keyframe.ride ? Se3Between::Source::ride : Se3Between::Source::odometry});
  }
  if (!committer.commit(edit).ok()) return false;
  if (!state.keyframes.empty() && keyframe.ride) state.rides.push_back({keyframe.id, *keyframe.ride});
  state.planes.drift.add(keyframe.id, keyframe.T_odom_base, covariance);
  state.keyframes[keyframe.id] = {keyframe.id, keyframe.stamp, *state.graph.find(keyframe.id), keyframe.T_odom_base, keyframe.scans, cloud};
  return true;
}

}  // namespace sgraph
