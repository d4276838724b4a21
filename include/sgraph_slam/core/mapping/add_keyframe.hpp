#pragma once

#include "sgraph_slam/core/mapping/map_state.hpp"
#include "sgraph_slam/core/types/odometry.hpp"

namespace sgraph {

/// Adds the keyframe and its motion since the last one (paper, Robot Tracking Layer). False when it isn't newer than the last, or not finite; that is
/// logged. `cloud`: the keyframe's, wherever it is kept.
bool add_keyframe(MapState& state, const Keyframe& keyframe, const KeyframeCloud& cloud);

}  // namespace sgraph
