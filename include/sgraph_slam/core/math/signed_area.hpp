#pragma once

#include <vector>

#include <Eigen/Core>

namespace sgraph {

/// Area of a polygon [m^2]; negative when it runs clockwise, 0 for fewer than three corners.
double signed_area(const std::vector<Eigen::Vector2d>& corners);

/// The same less what holes take away, however they run.
double signed_area(const std::vector<Eigen::Vector2d>& corners, const std::vector<std::vector<Eigen::Vector2d>>& holes);

}  // namespace sgraph
