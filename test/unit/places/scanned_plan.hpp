#pragma once

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "sgraph_slam/core/places/free_space.hpp"
#include "support/plan.hpp"

namespace sgraph {

/// A hand-drawn plan and what a LiDAR 0.7 m above its floor saw from some positions. Walls are as high as the rays unless they have a height.
struct ScannedPlan {
  Plan plan;
  std::vector<Eigen::Vector2d> path;
  std::map<KeyframeId, Pose> poses;
  FreeSpace space{FreeSpaceParams{}};
  std::vector<std::pair<KeyframeId, Cloud>> clouds;
  std::map<std::size_t, double> heights;            ///< of walls that rays can pass over, by their place in the plan [m]
  std::map<std::size_t, double> undersides;         ///< of beams: rays pass below [m]
  std::set<std::size_t> panes;                      ///< walls of glass: they give back what meets them squarely
  std::size_t door = static_cast<std::size_t>(-1);  ///< a leaf that opens: it is seen by the first `closed_until` keyframes only
  std::size_t closed_until = 0;
  int stray = 0;  ///< every so many rays end on something that is not there any more; 0: none

  /// Both faces of a wall of 0.15 m about the line from a to b.
  void wall(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const std::vector<Interval>& holes = {}) {
    const Eigen::Vector2d left = 0.075 * Eigen::Vector2d(-(b - a).y(), (b - a).x()).normalized();
    plan.add(a + left, b + left, holes);
    std::vector<Interval> back;
    for (const Interval& hole : holes) back.push_back({(b - a).norm() - hole.high, (b - a).norm() - hole.low});
    plan.add(b - left, a - left, back);
    const Eigen::Vector2d along = (b - a).normalized();
    for (const Interval& hole : holes) {  // jambs
      plan.add(a + hole.low * along - left, a + hole.low * along + left);
      plan.add(a + hole.high * along + left, a + hole.high * along - left);
    }
  }

  /// The faces of a room seen from inside only.
  void face(const std::vector<Eigen::Vector2d>& corners, const std::vector<std::vector<Interval>>& holes = {}) {
    for (std::size_t i = 0; i < corners.size(); ++i)
      plan.add(corners[i], corners[(i + 1) % corners.size()], i < holes.size() ? holes[i] : std::vector<Interval>{});
  }

  /// The four faces of a box that stands on the floor.
  void box(const Eigen::Vector2d& low, const Eigen::Vector2d& high, double height) {
    const std::vector<Eigen::Vector2d> corners{low, {low.x(), high.y()}, high, {high.x(), low.y()}};
    for (std::size_t i = 0; i < 4; ++i) {
      heights[plan.walls.size()] = height;
      plan.add(corners[i], corners[(i + 1) % 4]);
    }
  }

  /// Walks along the points and looks around every half metre.
  void walk(const std::vector<Eigen::Vector2d>& points) {
    for (Wall& wall : plan.walls) wall.views = 20;
    for (std::size_t i = 1; i < points.size(); ++i) {
      const Eigen::Vector2d way = points[i] - points[i - 1];
      const int steps = std::max(1, static_cast<int>(way.norm() / 0.5));
      for (int k = 0; k < steps; ++k) look_from(points[i - 1] + way * k / steps);
    }
    look_from(points.back());
    space.update(poses, 0);
  }

  /// Gives a layer what has been seen.
  template <class Layer>
  void add_to(Layer& layer) const {
    for (const auto& [id, cloud] : clouds) layer.add(id, cloud, Pose{});
  }

 private:
  int rays_ = 0;

  void look_from(const Eigen::Vector2d& p) {
    path.push_back(p);
    const KeyframeId id{static_cast<std::int64_t>(poses.size())};
    poses[id] = {Eigen::Quaterniond::Identity(), {p.x(), p.y(), 0.7}};
    Cloud cloud;
    for (int i = 0; i < 720; ++i) {
      const double azimuth = i * M_PI / 360;
      const Eigen::Vector2d u(std::cos(azimuth), std::sin(azimuth));
      for (const double slope : {-0.12, -0.04, 0.02, 0.1, 0.25}) {
        double range = std::min(range_along(p, u, slope), 30.0);
        if (stray > 0 && ++rays_ % stray == 0) range *= 0.05 + 0.9 * std::fmod(0.618034 * rays_, 1.0);
        const double reached = slope < 0 ? std::min(range, 0.7 / -slope) : range;
        Point point;
        point.set_position(Eigen::Vector3d(reached * u.x(), reached * u.y(), reached * slope).cast<float>());
        cloud.points.push_back(point);
      }
    }
    space.add(id, cloud, Pose{});
    clouds.emplace_back(id, std::move(cloud));
  }

  [[nodiscard]] double range_along(const Eigen::Vector2d& p, const Eigen::Vector2d& u, double slope) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < plan.walls.size(); ++i) {
      const Wall& wall = plan.walls[i];
      const auto height = heights.find(i);
      const double across = wall.normal.dot(u);
      if (std::abs(across) < 1e-9) continue;
      const double range = -wall.distance(p) / across;
      if (range <= 0 || range >= nearest) continue;
      if (i == door && poses.size() > closed_until) continue;
      if (panes.count(i) > 0 && std::abs(across) < 0.97) continue;
      if (height != heights.end() && 0.7 + slope * range > height->second) continue;
      const auto underside = undersides.find(i);
      if (underside != undersides.end() && 0.7 + slope * range < underside->second) continue;
      const double along = wall.direction().dot(p + range * u);
      for (const Interval& part : wall.support) {
        if (along >= part.low && along <= part.high) nearest = range;
      }
    }
    return nearest;
  }
};

}  // namespace sgraph
