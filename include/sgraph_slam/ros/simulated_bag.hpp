#pragma once

#include <functional>
#include <string>

#include "sgraph_slam/core/sim/simulator.hpp"

namespace sgraph {

/// Records a simulated run as a robot's bag: /velodyne_points (as velodyne_pointcloud publishes a VLP-16: x y z intensity float32, ring uint16, time
/// float32, packed in 22 bytes), /odom, /imu/data and a latched /tf_static with base_link -> velodyne. LZ4. `progress` is told the number of scans
/// written after each. Throws std::runtime_error when the file can't be written.
void write_simulated_bag(sim::SimulatedSource& source, const std::string& path, const std::function<void(int)>& progress);

}  // namespace sgraph
