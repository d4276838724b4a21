#include "sgraph_slam/core/places/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace sgraph {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

Eigen::Vector2d centroid(const Polygon2d& polygon) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  if (polygon.empty()) return mean;
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d p = polygon[i] - polygon[0];
    const Eigen::Vector2d q = polygon[(i + 1) % polygon.size()] - polygon[0];
    twice += cross(p, q);
    sum += cross(p, q) * (p + q) / 3;
    mean += p / static_cast<double>(polygon.size());
  }
  return polygon[0] + (std::abs(twice) > 1e-12 ? (sum / twice).eval() : mean);
}

bool contains(const Polygon2d& polygon, const Eigen::Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

double distance_to_outline(const Polygon2d& polygon, const Eigen::Vector2d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d side = polygon[(i + 1) % polygon.size()] - a;
    const double length2 = side.squaredNorm();
    const double t = length2 > 0 ? std::clamp((p - a).dot(side) / length2, 0.0, 1.0) : 0;
    least = std::min(least, (p - a - t * side).norm());
  }
  return least;
}

Polygon2d clipped(const Polygon2d& convex, const Eigen::Vector2d& normal, double offset) {
  Polygon2d kept;
  for (std::size_t i = 0; i < convex.size(); ++i) {
    const Eigen::Vector2d& a = convex[i];
    const Eigen::Vector2d& b = convex[(i + 1) % convex.size()];
    const double da = normal.dot(a) + offset;
    const double db = normal.dot(b) + offset;
    if (da >= 0) kept.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) kept.emplace_back(a + (b - a) * (da / (da - db)));
  }
  return kept;
}

Eigen::Vector2d inner_point(const Polygon2d& polygon, const std::vector<Polygon2d>& holes) {
  // Negative outside.
  const auto depth = [&](const Eigen::Vector2d& p) {
    if (!contains(polygon, p)) return -1.0;
    double least = distance_to_outline(polygon, p);
    for (const Polygon2d& hole : holes) {
      if (contains(hole, p)) return -1.0;
      least = std::min(least, distance_to_outline(hole, p));
    }
    return least;
  };
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : polygon) box.extend(p);
  Eigen::Vector2d best = centroid(polygon);
  double furthest = depth(best);
  // Coarse to fine: a grid over the box, then ever smaller ones around the best.
  Eigen::Vector2d half = 0.5 * box.sizes();
  Eigen::Vector2d middle = box.center();
  for (int level = 0; level < 6; ++level) {
    constexpr int steps = 8;
    for (int i = -steps; i <= steps; ++i) {
      for (int k = -steps; k <= steps; ++k) {
        const Eigen::Vector2d p = middle + Eigen::Vector2d(i * half.x() / steps, k * half.y() / steps);
        const double distance = depth(p);
        if (distance > furthest + 1e-9) {
          furthest = distance;
          best = p;
        }
      }
    }
    middle = best;
    half /= 0.5 * steps;
    if (half.maxCoeff() < 0.05) break;
  }
  return best;
}

}  // namespace sgraph
