#include "sgraph_slam/core/places/oriented_rectangle.hpp"

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/places/polygon.hpp"

namespace sgraph {
namespace {

Eigen::Vector2d unit(double yaw) { return {std::cos(yaw), std::sin(yaw)}; }

}  // namespace

bool OrientedRectangle::contains(const Eigen::Vector2d& p, double margin) const {
  const Eigen::Vector2d x = unit(yaw);
  const Eigen::Vector2d off = p - center;
  return std::abs(x.dot(off)) <= 0.5 * size.x() - margin && std::abs(x.x() * off.y() - x.y() * off.x()) <= 0.5 * size.y() - margin;
}

double shared_area(const OrientedRectangle& a, const OrientedRectangle& b) {
  const Eigen::Vector2d ax = unit(a.yaw) * a.size.x() / 2;
  const Eigen::Vector2d ay = unit(a.yaw + M_PI / 2) * a.size.y() / 2;
  Polygon2d polygon{a.center - ax - ay, a.center + ax - ay, a.center + ax + ay, a.center - ax + ay};
  const Eigen::Vector2d bx = unit(b.yaw);
  const Eigen::Vector2d by = unit(b.yaw + M_PI / 2);
  polygon = clipped(polygon, -bx, bx.dot(b.center) + b.size.x() / 2);
  polygon = clipped(polygon, bx, -bx.dot(b.center) + b.size.x() / 2);
  polygon = clipped(polygon, -by, by.dot(b.center) + b.size.y() / 2);
  polygon = clipped(polygon, by, -by.dot(b.center) + b.size.y() / 2);
  return std::max(0.0, signed_area(polygon));
}

}  // namespace sgraph
