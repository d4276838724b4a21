#include "sgraph_slam/core/math/outline_area.hpp"

#include <Eigen/Geometry>

namespace sgraph {

double outline_area(const std::vector<Eigen::Vector3d>& corners) {
  Eigen::Vector3d twice = Eigen::Vector3d::Zero();
  for (std::size_t i = 2; i < corners.size(); ++i) twice += (corners[i - 1] - corners[0]).cross(corners[i] - corners[0]);
  return 0.5 * twice.norm();
}

}  // namespace sgraph
