#pragma once

namespace sgraph {

/// Storeys count up from 0, that of the first keyframe. This is where keyframes and planes are that are on none: on stairs and ramps.
constexpr int stairwell = -1;

}  // namespace sgraph
