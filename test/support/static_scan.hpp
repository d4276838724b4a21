#pragma once

#include <cstdint>
#include <vector>

#include "sgraph_slam/core/sim/scene.hpp"
#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph::test {

/// A rectangle by one corner and its two edges; what it hides needn't be left out.
sim::Surface rectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& edge_a, const Eigen::Vector3d& edge_b);

/// The six sides of a box between two corners, seen from within or without.
std::vector<sim::Surface> box(const Eigen::Vector3d& low, const Eigen::Vector3d& high);

/// A scan of a VLP-16 standing still, in its own frame, in order of firing, with Gaussian range noise and all times `time`.
Cloud static_scan(const sim::Scene& scene, const Pose& T_world_lidar, double noise, std::uint64_t seed, double time = 0);

/// A keyframe's cloud of such scans, 0.1 s apart: in the frame of the last pose, one point a 5 cm voxel; its viewpoints are
/// the poses' positions.
Cloud keyframe_scan(const sim::Scene& scene, const std::vector<Pose>& T_world_lidar, double noise, std::uint64_t seed);

}  // namespace sgraph::test
