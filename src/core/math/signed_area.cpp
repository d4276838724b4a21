#include "sgraph_slam/core/math/signed_area.hpp"

#include <cmath>

namespace sgraph {

double signed_area(const std::vector<Eigen::Vector2d>& corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    // From the first corner, so that nothing cancels far from the origin.
    const Eigen::Vector2d a = corners[i] - corners[0];
    const Eigen::Vector2d b = corners[(i + 1) % corners.size()] - corners[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

double signed_area(const std::vector<Eigen::Vector2d>& corners, const std::vector<std::vector<Eigen::Vector2d>>& holes) {
  double area = signed_area(corners);
  for (const auto& hole : holes) area -= std::abs(signed_area(hole));
  return area;
}

}  // namespace sgraph
