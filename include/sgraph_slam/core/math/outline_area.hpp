#pragma once

#include <vector>

#include <Eigen/Core>

namespace sgraph {

/// Area of a flat polygon in space [m^2]; 0 for fewer than three corners.
double outline_area(const std::vector<Eigen::Vector3d>& corners);

}  // namespace sgraph
