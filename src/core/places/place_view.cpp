#include "sgraph_slam/core/places/place_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sgraph_slam/core/places/dominant_wall.hpp"
#include "sgraph_slam/core/planes/dominant_frame.hpp"

namespace sgraph {
namespace {

Eigen::Vector2d unit(double yaw) { return {std::cos(yaw), std::sin(yaw)}; }

double distance_to(const Wall& wall, const Eigen::Vector2d& p) {
  const Interval stretch = hull(wall.support);
  const double along = std::clamp(wall.direction().dot(p), stretch.low, stretch.high);
  return (p - wall.at(along)).norm();
}

// The side that a wall with this normal would bound, or -1.
int side_of(const Wall& wall, const PlaceView& view, double parallel) {
  const double limit = std::cos(parallel);
  const double x = wall.normal.dot(view.x_axis);
  const double y = wall.normal.dot(view.y_axis);
  if (x > limit) return low_x;
  if (x < -limit) return high_x;
  if (y > limit) return low_y;
  if (y < -limit) return high_y;
  return -1;
}

Face face_of(const Wall& wall, std::size_t index, bool across_x, const PlaceView& view, const Eigen::Vector2d& position) {
  const Eigen::Vector2d& across = across_x ? view.x_axis : view.y_axis;
  const Eigen::Vector2d& along = across_x ? view.y_axis : view.x_axis;
  Face face;
  face.wall = index;
  face.trust = trust(wall);
  face.height = wall.height;
  // Where the wall is seen nearest to the position: a short piece a few degrees off would be anywhere, if it were prolonged.
  const Interval stretch = hull(wall.support);
  face.position = across.dot(wall.at(std::clamp(wall.direction().dot(position), stretch.low, stretch.high)));
  for (const Interval& part : wall.support) {
    const double a = along.dot(wall.at(part.low));
    const double b = along.dot(wall.at(part.high));
    face.span.push_back({std::min(a, b), std::max(a, b)});
  }
  face.span = unite(std::move(face.span));
  return face;
}

// The part of a polygon on the inner side of the line normal . p <= offset.
std::vector<Eigen::Vector2d> cut(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& normal, double offset) {
  std::vector<Eigen::Vector2d> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    const double da = normal.dot(a) - offset;
    const double db = normal.dot(b) - offset;
    if (da <= 0) kept.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) kept.emplace_back(a + (b - a) * (da / (da - db)));
  }
  return kept;
}

}  // namespace

PlaceView view_from(const std::vector<Wall>& walls, const Eigen::Vector2d& position_map, double yaw, double reach, double parallel) {
  PlaceView view;
  view.yaw = yaw;
  view.x_axis = unit(yaw);
  view.y_axis = {-view.x_axis.y(), view.x_axis.x()};
  for (std::size_t i = 0; i < walls.size(); ++i) {
    if (distance_to(walls[i], position_map) > reach) continue;
    const int side = side_of(walls[i], view, parallel);
    if (side >= 0) {
      view.faces[static_cast<std::size_t>(side)].push_back(face_of(walls[i], i, side == low_x || side == high_x, view, position_map));
    } else {
      const Interval stretch = hull(walls[i].support);
      view.oblique.push_back({i, view.to_place(walls[i].at(stretch.low)), view.to_place(walls[i].at(stretch.high))});
    }
  }
  return view;
}

std::vector<double> local_yaws(const std::vector<Wall>& walls, const Eigen::Vector2d& position_map, double reach, double parallel,
                               std::size_t count) {
  std::vector<WallDirection> left;
  for (const Wall& wall : walls) {
    if (distance_to(wall, position_map) <= reach) left.push_back({std::atan2(wall.normal.y(), wall.normal.x()), total_length(wall.support)});
  }
  std::vector<double> yaws;
  while (yaws.size() < count && !left.empty()) {
    DominantFrameParams params;
    params.bin = 0.25 * parallel;
    params.min_length = 0;
    const DominantFrame frame = estimate_dominant_frame(left, {}, params);
    if (!frame.known()) break;
    yaws.push_back(frame.yaw);
    left.erase(
        std::remove_if(left.begin(), left.end(), [&](const WallDirection& w) { return std::abs(wrap_quarter(w.yaw - frame.yaw)) <= parallel; }),
        left.end());
  }
  return yaws;
}

double side_coverage(const std::vector<Face>& same_side, bool low, double at, Interval within, double coplanar, double inside) {
  if (!(within.length() > 0)) return 0;
  Intervals seen;
  for (const Face& face : same_side) {
    const double inwards = low ? face.position - at : at - face.position;
    if (inwards < -coplanar || inwards > std::max(coplanar, inside)) continue;
    seen.insert(seen.end(), face.span.begin(), face.span.end());
  }
  return total_length(clip(unite(std::move(seen)), within)) / within.length();
}

Intervals coplanar_span(const std::vector<Face>& same_side, double at, double coplanar, double gap) {
  Intervals seen;
  for (const Face& face : same_side) {
    if (std::abs(face.position - at) <= coplanar) seen.insert(seen.end(), face.span.begin(), face.span.end());
  }
  return unite(std::move(seen), gap);
}

bool OrientedRectangle::contains(const Eigen::Vector2d& p, double margin) const {
  const Eigen::Vector2d x = unit(yaw);
  const Eigen::Vector2d off = p - center;
  return std::abs(x.dot(off)) <= 0.5 * size.x() - margin && std::abs(x.x() * off.y() - x.y() * off.x()) <= 0.5 * size.y() - margin;
}

double shared_area(const OrientedRectangle& a, const OrientedRectangle& b) {
  const auto axes = [](const OrientedRectangle& r) { return std::pair<Eigen::Vector2d, Eigen::Vector2d>{unit(r.yaw), unit(r.yaw + M_PI / 2)}; };
  const auto [ax, ay] = axes(a);
  std::vector<Eigen::Vector2d> polygon{a.center - ax * a.size.x() / 2 - ay * a.size.y() / 2, a.center + ax * a.size.x() / 2 - ay * a.size.y() / 2,
                                       a.center + ax * a.size.x() / 2 + ay * a.size.y() / 2, a.center - ax * a.size.x() / 2 + ay * a.size.y() / 2};
  const auto [bx, by] = axes(b);
  polygon = cut(polygon, bx, bx.dot(b.center) + b.size.x() / 2);
  polygon = cut(polygon, -bx, -bx.dot(b.center) + b.size.x() / 2);
  polygon = cut(polygon, by, by.dot(b.center) + b.size.y() / 2);
  polygon = cut(polygon, -by, -by.dot(b.center) + b.size.y() / 2);
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto& p = polygon[i];
    const auto& q = polygon[(i + 1) % polygon.size()];
    twice += p.x() * q.y() - p.y() * q.x();
  }
  return std::max(0.0, 0.5 * twice);
}

}  // namespace sgraph
