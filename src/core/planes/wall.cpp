#include "sgraph_slam/core/planes/wall.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sgraph {
namespace {

constexpr int views_a_vote = 25;  // of a wall with many views a piece counts when as many as one in this number saw it,
constexpr int most_votes = 4;     // though never more than this many are asked for

Eigen::Vector2d left_of(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

// The wall's hull along another direction.
Interval hull_along(const Wall& wall, const Eigen::Vector2d& direction) {
  const Interval own = hull(wall.support);
  const double a = direction.dot(wall.at(own.low));
  const double b = direction.dot(wall.at(own.high));
  return {std::min(a, b), std::max(a, b)};
}

// Position along `axis` where the wall crosses the line through `foot` in that direction.
double crossing(const Wall& wall, const Eigen::Vector2d& axis, const Eigen::Vector2d& foot) {
  return axis.dot(foot) - wall.distance(foot) / wall.normal.dot(axis);
}

}  // namespace

std::optional<Wall> make_wall(PlaneId id, const Plane& plane, const std::vector<std::vector<Eigen::Vector3d>>& outlines, double tilt, double gap) {
  const double level = plane.normal.head<2>().norm();
  if (level < std::cos(tilt)) return std::nullopt;
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const auto& outline : outlines) {
    for (const auto& p : outline) {
      low = std::min(low, p.z());
      high = std::max(high, p.z());
    }
  }
  if (!(low <= high)) return std::nullopt;
  Wall wall;
  wall.id = id;
  wall.height = high - low;
  wall.normal = plane.normal.head<2>() / level;
  wall.offset = (plane.d + plane.normal.z() * 0.5 * (low + high)) / level;
  Intervals parts;
  for (const auto& outline : outlines) {
    Interval part{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (const auto& p : outline) {
      const double along = wall.direction().dot(p.head<2>());
      part.low = std::min(part.low, along);
      part.high = std::max(part.high, along);
    }
    parts.push_back(part);
  }
  // One view in a hundred takes a door leaf or somebody's back for a piece of the wall.
  const int needed = std::clamp(static_cast<int>(parts.size()) / views_a_vote, 1, most_votes);
  wall.support = unite(covered(parts, needed), gap);
  if (wall.support.empty()) return std::nullopt;
  return wall;
}

std::optional<FacingPair> facing_pair(const Wall& first, const Wall& second, double parallel) {
  if (first.normal.dot(second.normal) > -std::cos(parallel)) return std::nullopt;
  FacingPair pair;
  pair.axis = (first.normal - second.normal).normalized();
  const Eigen::Vector2d along = left_of(pair.axis);
  const Interval a = hull_along(first, along);
  const Interval b = hull_along(second, along);
  pair.common = {std::max(a.low, b.low), std::min(a.high, b.high)};
  const Eigen::Vector2d foot = pair.common.center() * along;
  pair.s1 = crossing(first, pair.axis, foot);
  pair.s2 = crossing(second, pair.axis, foot);
  pair.width = pair.s2 - pair.s1;
  return pair;
}

}  // namespace sgraph
