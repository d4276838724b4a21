#include "sgraph_slam/core/registration/vertical.hpp"

#include <cmath>

#include <Eigen/Eigenvalues>

namespace sgraph {
namespace {

constexpr double widest = 0.45;    // [rad] that a surface may be off the level or the upright at first,
constexpr double narrowest = 0.1;  // and at the end
constexpr int rounds = 4;
constexpr int fewest = 12;      // surfaces within the last
constexpr double clear = 0.05;  // difference of the directions' measures, a surface, that tells the vertical from a wall's own horizontal

}  // namespace

std::optional<Eigen::Vector3d> vertical_of(const SurfaceMap& map, const Eigen::Vector3d& guess) {
  const std::vector<Surface> surfaces = map.surfaces();
  Eigen::Vector3d up = guess;
  for (int i = 0; i < rounds; ++i) {
    const double off = std::sin(widest * std::pow(narrowest / widest, static_cast<double>(i) / (rounds - 1)));
    // Floors and ceilings have the vertical for their normal, walls lie at right angles to it.
    Eigen::Matrix3d measure = Eigen::Matrix3d::Zero();
    int count = 0;
    for (const Surface& surface : surfaces) {
      const double along = std::abs(surface.normal.dot(up));
      const bool level = along > std::sqrt(1 - off * off);
      if (!level && along > off) continue;
      measure += (level ? -1.0 : 1.0) * surface.normal * surface.normal.transpose();
      ++count;
    }
    if (count < fewest) return std::nullopt;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(measure);
    if (solver.eigenvalues()[1] - solver.eigenvalues()[0] < clear * count) return std::nullopt;
    up = solver.eigenvectors().col(0);
    if (up.dot(guess) < 0) up *= -1;
  }
  return up;
}

}  // namespace sgraph
