#include "noisy_box.hpp"

#include <random>

namespace sgraph::test {

std::vector<SidePoint> noisy_box(const Eigen::Vector3d& size, BoxSides sides, int count, double noise, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  std::normal_distribution<double> normal;
  std::vector<SidePoint> points;
  for (int i = 0; i < count; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    const int axis = i % 3 == 1 && sides.level ? 2 : i % 3 == 2 && sides.across ? 0 : 1;
    Eigen::Vector3d p = size.cwiseProduct(Eigen::Vector3d(unit(random), unit(random), unit(random)));
    p[axis] = 0.5 * side * size[axis] + noise * normal(random);
    points.push_back({p, -side * Eigen::Vector3d::Unit(axis)});
  }
  return points;
}

}  // namespace sgraph::test
