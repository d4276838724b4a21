#pragma once

#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// Gives the points of a cloud without times the times at which a sensor fires that turns evenly: once in `turn` [s], in the direction `turn_sign`
/// (+1 counter-clockwise). `stamp_fraction`: of the cloud's sweep that has passed at its stamp.
void times_from_azimuth(Cloud& cloud, double turn, double turn_sign, double stamp_fraction);

}  // namespace sgraph
