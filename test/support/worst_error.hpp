#pragma once

#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph::test {

/// Largest distance from the truth, both starting at the origin [m].
double worst_error(const Trajectory& estimate, const Trajectory& truth);

}  // namespace sgraph::test
