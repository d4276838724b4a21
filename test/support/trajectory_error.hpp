#pragma once

#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph::test {

/// Largest distance from the truth, both starting at the origin [m].
double worst_error(const Trajectory& estimate, const Trajectory& truth);

/// Absolute trajectory error: rms of the distances from the truth after the best rigid alignment [m].
double ate(const Trajectory& estimate, const Trajectory& truth);

}  // namespace sgraph::test
