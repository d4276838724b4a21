#pragma once

#include "sgraph_slam/core/odometry/acceptance.hpp"
#include "sgraph_slam/core/odometry/map_updater.hpp"
#include "sgraph_slam/core/odometry/window_scan.hpp"
#include "sgraph_slam/core/registration/rigid_alignment.hpp"

namespace sgraph {

/// A scan to be placed.
struct StartQuery {
  const WindowScan& scan;
  const Knots& knots;  ///< predicted up to the scan's end
  double last_end;     ///< of the scan before [s]
};

/// Finds where a new scan begins: aligned as one rigid body on its predicted motion, and when that fits much worse than usual (after a gap, a jerk),
/// from other starts around it.
RigidAlignmentResult find_start(const MapUpdater& local, const Acceptance& acceptance, const StartQuery& query);

}  // namespace sgraph
