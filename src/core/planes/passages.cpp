#include "sgraph_slam/core/planes/passages.hpp"

#include <algorithm>

namespace sgraph {
namespace {

constexpr double inside = 0.2;      // [m] from the end of a stretch: the path is cut short at corners
constexpr double half_width = 0.4;  // of a passage [m]
constexpr double scrap = 0.5;       // [m] beside a passage

// Positions along the wall's line where the path crosses it.
std::vector<double> crossings(const Wall& wall, const std::vector<Eigen::Vector2d>& path) {
  std::vector<double> found;
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double from = wall.distance(path[i - 1]);
    const double to = wall.distance(path[i]);
    if ((from > 0) == (to > 0)) continue;
    found.push_back(wall.direction().dot(path[i - 1] + from / (from - to) * (path[i] - path[i - 1])));
  }
  return found;
}

bool leads_through(const Interval& stretch, double at) { return at > stretch.low + inside && at < stretch.high - inside; }

}  // namespace

void open_passages(Wall& wall, const std::vector<Eigen::Vector2d>& path) {
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
