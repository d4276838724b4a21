#include "polygon.hpp"

#include <cmath>

namespace sgraph {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

bool contains(const Polygon& polygon, const Eigen::Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y())) inside = !inside;
  }
  return inside;
}

double area(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return 0.5 * std::abs(twice);
}

Polygon rectangle(const Eigen::Vector2d& center, const Eigen::Vector2d& width, double yaw) {
  const Eigen::Vector2d x = 0.5 * width.x() * Eigen::Vector2d(std::cos(yaw), std::sin(yaw));
  const Eigen::Vector2d y = 0.5 * width.y() * Eigen::Vector2d(-std::sin(yaw), std::cos(yaw));
  return {center - x - y, center + x - y, center + x + y, center - x + y};
}

Polygon clip(const Polygon& subject, const Polygon& convex) {
  Polygon kept = subject;
  for (std::size_t i = 0; i < convex.size() && !kept.empty(); ++i) {
    const Eigen::Vector2d& a = convex[i];
    const Eigen::Vector2d edge = convex[(i + 1) % convex.size()] - a;
    const Polygon before = kept;
    kept.clear();
    for (std::size_t k = 0; k < before.size(); ++k) {
      const Eigen::Vector2d& p = before[k];
      const Eigen::Vector2d& next = before[(k + 1) % before.size()];
      const double side = cross(edge, p - a);
      const double next_side = cross(edge, next - a);
      if (side >= 0) kept.push_back(p);
      if ((side >= 0) != (next_side >= 0)) kept.push_back(p + (next - p) * (side / (side - next_side)));
    }
  }
  return kept;
}

}  // namespace sgraph
