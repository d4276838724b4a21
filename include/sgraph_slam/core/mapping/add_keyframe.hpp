#pragma once

#include "sgraph_slam/core/mapping/map_state.hpp"

namespace sgraph {

/// Adds the keyframe and its motion since the last one (paper, Robot Tracking Layer). False when it isn't newer than the last, or not finite; that is
/// logged.
bool add_keyframe(MapState& state, const Keyframe& keyframe);

}  // namespace sgraph
