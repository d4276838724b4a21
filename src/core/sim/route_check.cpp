#include "route_check.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "people.hpp"
#include "plan.hpp"
#include "regions.hpp"
#include "yaml_fields.hpp"

namespace sgraph::sim {

namespace {

constexpr double person_radius = 0.22;  // [m]

// A convex outline that stands in somebody's way.
struct Obstacle {
  std::vector<Eigen::Vector2d> outline;
  double bottom = 0;
  double top = 0;
  std::string what;
  int line = 0;
  Eigen::Vector2d low;
  Eigen::Vector2d high;
};

void add(std::vector<Obstacle>& obstacles, Obstacle obstacle) {
  obstacle.low = obstacle.high = obstacle.outline.front();
  for (const Eigen::Vector2d& p : obstacle.outline) {
    obstacle.low = obstacle.low.cwiseMin(p);
    obstacle.high = obstacle.high.cwiseMax(p);
  }
  obstacles.push_back(std::move(obstacle));
}

void add_walls(std::vector<Obstacle>& obstacles, const Storey& storey) {
  for (const Wall& wall : storey.walls) {
    const Eigen::Vector2d along = wall.direction();
    const Eigen::Vector2d across = 0.5 * wall.thickness * Eigen::Vector2d(-along.y(), along.x());
    for (const WallPiece& piece : pieces_of(wall, true)) {
      const Eigen::Vector2d a = wall.p + piece.begin * along;
      const Eigen::Vector2d b = wall.p + piece.end * along;
      add(obstacles,
          {{a - across, b - across, b + across, a + across}, wall.bottom + piece.bottom, wall.bottom + piece.top, "a wall", wall.line, {}, {}});
    }
  }
}

std::vector<Obstacle> obstacles_of(const World& world, bool walls_only) {
  std::vector<Obstacle> obstacles;
  for (const Storey& storey : world.storeys) {
    add_walls(obstacles, storey);
    if (walls_only) continue;
    for (const auto* blocks : {&storey.columns, &storey.furniture}) {
      for (const Block& block : *blocks) {
        const double half = 0.5 * block.size.z();
        add(obstacles, {footprint(block), block.center.z() - half, block.center.z() + half, "a " + block.name, block.line, {}, {}});
      }
    }
  }
  return obstacles;
}

// Distance from a point to a convex counter-clockwise outline; 0 inside.
double distance_to(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& p) {
  double nearest = 1e9;
  bool inside = true;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d edge = outline[(i + 1) % outline.size()] - outline[i];
    const Eigen::Vector2d to = p - outline[i];
    if (edge.x() * to.y() - edge.y() * to.x() < 0) inside = false;
    const double f = std::min(1.0, std::max(0.0, to.dot(edge) / std::max(edge.squaredNorm(), 1e-12)));
    nearest = std::min(nearest, (to - f * edge).norm());
  }
  return inside ? 0 : nearest;
}

const Obstacle* hit(const std::vector<Obstacle>& obstacles, const Eigen::Vector2d& p, double radius, double bottom, double top) {
  for (const Obstacle& obstacle : obstacles) {
    if (obstacle.top <= bottom || obstacle.bottom >= top) continue;
    if ((p - obstacle.low).minCoeff() < -radius || (obstacle.high - p).minCoeff() < -radius) continue;
    if (distance_to(obstacle.outline, p) < radius) return &obstacle;
  }
  return nullptr;
}

std::string place(const Eigen::Vector2d& p) {
  std::ostringstream text;
  text.precision(2);
  text << std::fixed << "(" << p.x() << ", " << p.y() << ")";
  return text.str();
}

std::size_t nearest_waypoint(const Route& route, const Eigen::Vector2d& p) {
  std::size_t best = 0;
  for (std::size_t i = 0; i < route.waypoints.size(); ++i) {
    if ((route.waypoints[i].position - p).norm() < (route.waypoints[best].position - p).norm()) best = i;
  }
  return best;
}

[[noreturn]] void refuse(const World& world, const Eigen::Vector2d& p, double time, const std::string& what) {
  const Waypoint& near = world.route.waypoints[nearest_waypoint(world.route, p)];
  std::ostringstream text;
  text.precision(1);
  text << std::fixed << "the route passes through " << what << " at " << place(p) << ", " << time << " s after the start, near waypoint "
       << place(near.position);
  fail_at(world.file, near.line, text.str());
}

bool within(const std::vector<Eigen::Vector2d>& polygon, const Eigen::Vector2d& p) {
  bool in = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) in = !in;
  }
  return in;
}

void check_robot(const World& world, const Motion& motion, const std::vector<Obstacle>& obstacles, double radius) {
  constexpr double clearance = 0.05;  // over the floor [m]
  constexpr double on_floor = 0.3;    // farther from every floor the robot is on stairs [m]
  const double tall = world.motion.base_height + std::max(0.0, world.T_base_lidar.translation.z()) + 0.15;
  const std::vector<PersonTrack> people(world.people.begin(), world.people.end());
  for (double t = 0; t <= motion.duration(); t += 0.05) {
    const Eigen::Vector3d base = motion.pose_at(t).translation;
    const Eigen::Vector2d p = base.head<2>();
    const double floor = base.z() - world.motion.base_height;
    if (const Obstacle* obstacle = hit(obstacles, p, radius, floor + clearance, floor + tall)) {
      refuse(world, p, t, obstacle->what + (obstacle->line > 0 ? " (line " + std::to_string(obstacle->line) + ")" : ""));
    }
    bool indoors = true;
    for (const Storey& storey : world.storeys) {
      if (std::abs(floor - storey.elevation) > on_floor) continue;
      indoors = std::any_of(storey.outlines.begin(), storey.outlines.end(), [&](const auto& outline) { return within(outline, p); });
    }
    if (!indoors) refuse(world, p, t, "the outline of the storey");
    for (std::size_t i = 0; i < people.size(); ++i) {
      if ((people[i].at(t).position - p).norm() < radius + 0.25) refuse(world, p, t, "person " + std::to_string(i + 1));
    }
  }
}

void check_people(const World& world, const std::vector<Obstacle>& obstacles, double radius) {
  for (const Person& person : world.people) {
    for (std::size_t i = 0; i + 1 < person.path.size(); ++i) {
      const Eigen::Vector2d leg = person.path[i + 1] - person.path[i];
      const int pieces = std::max(1, static_cast<int>(std::ceil(leg.norm() / 0.05)));
      for (int k = 0; k <= pieces; ++k) {
        const Eigen::Vector2d p = person.path[i] + leg * k / pieces;
        if (const Obstacle* obstacle = hit(obstacles, p, radius, person.z + 0.05, person.z + person.height)) {
          fail_at(world.file, person.line, "a person walks through " + obstacle->what + " at " + place(p));
        }
      }
    }
  }
}

// Furniture that sticks into a wall by more than a few centimetres is a mistake of the plan: the wall behind it seems nearer than it is.
void check_furniture(const World& world, const std::vector<Obstacle>& walls) {
  constexpr double allowed = 0.05;
  for (const Storey& storey : world.storeys) {
    for (Block piece : storey.furniture) {
      piece.size.head<2>() = (piece.size.head<2>().array() - 2 * allowed).max(0.01);
      const double half = 0.5 * piece.size.z();
      for (const Eigen::Vector2d& corner : footprint(piece)) {
        const Obstacle* wall = hit(walls, corner, 1e-6, piece.center.z() - half, piece.center.z() + half);
        if (wall != nullptr) fail_at(world.file, piece.line, "a " + piece.name + " sticks in a wall at " + place(corner));
      }
    }
  }
}

}  // namespace

void check_routes(const World& world, const Motion& motion) {
  check_furniture(world, obstacles_of(world, true));
  const std::vector<Obstacle> obstacles = obstacles_of(world, false);
  check_robot(world, motion, obstacles, world.motion.radius);
  check_people(world, obstacles, person_radius);
}

bool furniture_fits(const Storey& storey, int piece) {
  constexpr double spacing = 0.1;  // of the points of an outline that are looked at [m]
  std::vector<Obstacle> others;
  add_walls(others, storey);
  for (const auto* blocks : {&storey.columns, &storey.furniture}) {
    for (const Block& block : *blocks) {
      if (block.piece == piece && blocks == &storey.furniture) continue;
      const double half = 0.5 * block.size.z();
      add(others, {footprint(block), block.center.z() - half, block.center.z() + half, "", 0, {}, {}});
    }
  }
  for (const Block& block : storey.furniture) {
    if (block.piece != piece) continue;
    const double half = 0.5 * block.size.z();
    const std::vector<Eigen::Vector2d> outline = footprint(block);
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Eigen::Vector2d edge = outline[(i + 1) % outline.size()] - outline[i];
      const int count = std::max(1, static_cast<int>(std::ceil(edge.norm() / spacing)));
      for (int k = 0; k < count; ++k) {
        const Eigen::Vector2d p = outline[i] + edge * k / count;
        if (hit(others, p, 0.02, block.center.z() - half, block.center.z() + half) != nullptr) return false;
      }
    }
    if (region_at(storey.regions, block.center.head<2>()) < 0) return false;
  }
  return true;
}

void check_routes_as_built(const World& world) {
  constexpr double lenience = 0.05;
  const std::vector<Obstacle> obstacles = obstacles_of(world, false);
  check_robot(world, motion_along_route(world), obstacles, world.motion.radius - lenience);
  check_people(world, obstacles, person_radius - lenience);
}

}  // namespace sgraph::sim
