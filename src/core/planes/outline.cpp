#include "sgraph_slam/core/planes/outline.hpp"

#include <algorithm>
#include <limits>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

using Flat = std::vector<Eigen::Vector2d>;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Coordinates on the plane, along the two directions of its basis.
Flat flatten(const Plane& plane, const std::vector<Eigen::Vector3d>& points) {
  const Eigen::Matrix<double, 3, 2> basis = tangent_basis(plane.normal);
  Flat flat;
  flat.reserve(points.size());
  for (const auto& p : points) flat.emplace_back(basis.transpose() * p);
  return flat;
}

// Andrew's monotone chain; counter-clockwise, without collinear corners.
Flat convex_hull(Flat points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  Flat hull;
  const auto add = [&hull](const Eigen::Vector2d& p, std::size_t keep) {
    while (hull.size() >= keep + 2 && cross(hull[hull.size() - 1] - hull[hull.size() - 2], p - hull.back()) <= 1e-12) hull.pop_back();
    hull.push_back(p);
  };
  for (const auto& p : points) add(p, 0);
  const std::size_t lower = hull.size() - 1;
  for (auto p = points.rbegin() + 1; p != points.rend(); ++p) add(*p, lower);
  hull.pop_back();
  return hull;
}

// Drops the corners whose triangle with their neighbours is smallest.
void thin(Flat& hull, std::size_t max_corners) {
  while (hull.size() > std::max<std::size_t>(max_corners, 3)) {
    std::size_t least = 0;
    double least_area = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const auto& before = hull[(i + hull.size() - 1) % hull.size()];
      const auto& after = hull[(i + 1) % hull.size()];
      const double area = std::abs(cross(hull[i] - before, after - before));
      if (area < least_area) {
        least_area = area;
        least = i;
      }
    }
    hull.erase(hull.begin() + static_cast<std::ptrdiff_t>(least));
  }
}

double segment_distance(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

// Whether some edge of a has all of b on its outer side.
bool separated(const Flat& a, const Flat& b) {
  if (a.size() < 3) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Eigen::Vector2d edge = a[(i + 1) % a.size()] - a[i];
    if (std::all_of(b.begin(), b.end(), [&](const auto& p) { return cross(edge, p - a[i]) < 0; })) return true;
  }
  return false;
}

double corner_distance(const Flat& a, const Flat& b) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& p : a) {
    for (std::size_t i = 0; i < b.size(); ++i) least = std::min(least, segment_distance(p, b[i], b[(i + 1) % b.size()]));
  }
  return least;
}

}  // namespace

Outline convex_outline(const Plane& plane, const std::vector<Eigen::Vector3d>& points, std::size_t max_corners) {
  Flat hull = convex_hull(flatten(plane, points));
  thin(hull, max_corners);
  const Eigen::Matrix<double, 3, 2> basis = tangent_basis(plane.normal);
  Outline outline;
  outline.reserve(hull.size());
  for (const auto& p : hull) outline.emplace_back(basis * p - plane.d * plane.normal);
  return outline;
}

Outline grown_outline(const Plane& plane, const Outline& outline, const std::vector<Eigen::Vector3d>& points, std::size_t max_corners) {
  std::vector<Eigen::Vector3d> all(outline);
  all.insert(all.end(), points.begin(), points.end());
  return convex_outline(plane, all, max_corners);
}

double outline_distance(const Plane& plane, const Outline& a, const Outline& b) {
  if (a.empty() || b.empty()) return std::numeric_limits<double>::infinity();
  const Flat fa = convex_hull(flatten(plane, a));
  const Flat fb = convex_hull(flatten(plane, b));
  if (fa.size() >= 3 && fb.size() >= 3 && !separated(fa, fb) && !separated(fb, fa)) return 0;
  return std::min(corner_distance(fa, fb), corner_distance(fb, fa));
}

Outline moved_outline(const Pose& T_target_source, const Outline& outline) {
  Outline result;
  result.reserve(outline.size());
  for (const auto& p : outline) result.push_back(T_target_source * p);
  return result;
}

Eigen::Vector3d outline_center(const Outline& outline) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& p : outline) sum += p;
  return outline.empty() ? sum : Eigen::Vector3d(sum / static_cast<double>(outline.size()));
}

}  // namespace sgraph
