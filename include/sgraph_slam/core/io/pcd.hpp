#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace sgraph {

/// Positions of a point cloud file (PCD, ascii or binary) without the invalid ones. Throws std::runtime_error with the reason when it can't be read.
std::vector<Eigen::Vector3f> read_pcd_positions(const std::string& path);

}  // namespace sgraph
