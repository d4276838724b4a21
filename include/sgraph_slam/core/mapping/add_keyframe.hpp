#pragma once

#include "sgraph_slam/core/mapping/map_state.hpp"
#include "sgraph_slam/core/types/odometry.hpp"

namespace sgraph {

/// Adds the keyframe and its motion since the last one (paper, Robot Tracking Layer). False when it isn't newer than the last, or not finite; that is
/// logged. `cloud`: the keyframe's, wherever it is kept.
bool add_keyframe(MapState& state, const Keyframe& keyframe, const KeyframeCloud& cloud);

/// Whether the motion to a keyframe was a ride in a lift: nothing is known of its height, and all of its way on the ground. `base`: where it led, in
/// a frame whose z is up; `covariance` of it (rotation, translation; right perturbation).
bool is_ride(const Pose& base, const Matrix6& covariance);

}  // namespace sgraph
