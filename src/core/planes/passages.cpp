#include "sgraph_slam/core/planes/passages.hpp"

#include <algorithm>

namespace sgraph {
namespace {

constexpr double inside = 0.2;      // [m] from the end of a stretch: the path is cut short at corners
constexpr double half_width = 0.4;  // of a passage [m]
constexpr double scrap = 0.5;       // [m] beside a passage

// Positions along the wall's line where the path crosses what has been seen of it, in the order of the path.
std::vector<double> crossings(const Wall& wall, const GroundPath& path) {
  std::vector<double> found;
  const std::vector<Eigen::Vector2d>& points = path.points();
  const Interval seen = hull(wall.support);
  for (const std::size_t i : path.steps_near(wall.at(seen.low), wall.at(seen.high))) {
    const double from = wall.distance(points[i - 1]);
    const double to = wall.distance(points[i]);
    if ((from > 0) == (to > 0)) continue;
    found.push_back(wall.direction().dot(points[i - 1] + from / (from - to) * (points[i] - points[i - 1])));
  }
  return found;
}

bool leads_through(const Interval& stretch, double at) { return at > stretch.low + inside && at < stretch.high - inside; }

}  // namespace

void open_passages(Wall& wall, const GroundPath& path) {
  if (wall.support.empty()) return;
  for (const double at : crossings(wall, path)) {
    Intervals left;
    for (const Interval& stretch : wall.support) {
      if (!leads_through(stretch, at)) {
        left.push_back(stretch);
        continue;
      }
      for (const Interval& beside : {Interval{stretch.low, at - half_width}, Interval{at + half_width, stretch.high}}) {
        if (beside.length() >= scrap) left.push_back(beside);
      }
    }
    wall.support = std::move(left);
  }
}

}  // namespace sgraph
