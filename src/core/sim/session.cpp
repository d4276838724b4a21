#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "plan.hpp"
#include "regions.hpp"
#include "route_check.hpp"
#include "sgraph_slam/core/sim/world.hpp"
#include "sgraph_slam/core/util/rng.hpp"
#include "streams.hpp"

namespace sgraph::sim {

namespace {

bool possible(const World& world) {
  try {
    check_routes_as_built(world);
    return true;
  } catch (const WorldError&) {
    return false;
  }
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// The same round the other way about, begun somewhere else; a route that doesn't come back is walked from its end. One round.
void change_route(World& world, RandomStream& random) {
  std::vector<Waypoint>& waypoints = world.route.waypoints;
  if (waypoints.size() < 3) return;
  const bool closed = (waypoints.front().position - waypoints.back().position).norm() < 1e-9;
  std::reverse(waypoints.begin(), waypoints.end());
  if (closed) {
    waypoints.pop_back();
    // One round: up to where the list repeats itself.
    for (std::size_t period = 2; period <= waypoints.size() / 2; ++period) {
      bool repeats = waypoints.size() % period == 0;
      for (std::size_t i = period; i < waypoints.size() && repeats; ++i)
        repeats = (waypoints[i].position - waypoints[i - period].position).norm() < 1e-9;
      if (!repeats) continue;
      waypoints.resize(period);
      break;
    }
    const auto count = static_cast<double>(waypoints.size());
    const auto start = static_cast<std::ptrdiff_t>(count * (0.2 + 0.6 * random.next_uniform()));
    std::rotate(waypoints.begin(), waypoints.begin() + start, waypoints.end());
    waypoints.push_back(waypoints.front());
  }
  world.route.duration = 0;
  const Eigen::Vector2d leg = waypoints[1].position - waypoints[0].position;
  world.route.start_heading = std::atan2(leg.y(), leg.x()) + 2 * M_PI * random.next_uniform();
}

// Legs of the route, by their first waypoint, that lead through a door.
std::vector<std::size_t> passages(const Route& route, const Wall& wall, const Opening& door) {
  std::vector<std::size_t> legs;
  for (std::size_t i = 0; i + 1 < route.waypoints.size(); ++i) {
    const Eigen::Vector2d a = route.waypoints[i].position - wall.p;
    const Eigen::Vector2d b = route.waypoints[i + 1].position - wall.p;
    if (std::abs(route.waypoints[i].z - wall.bottom) > 0.5) continue;
    const double da = cross(wall.direction(), a);
    const double db = cross(wall.direction(), b);
    if ((da > 0) == (db > 0)) continue;
    const double at = (a + (b - a) * (da / (da - db))).dot(wall.direction());
    if (at > door.begin && at < door.end) legs.push_back(i);
  }
  return legs;
}

// The route without what lies behind a door; nothing when it starts there.
std::optional<Route> without_door(const Route& route, const Wall& wall, const Opening& door) {
  const std::vector<std::size_t> legs = passages(route, wall, door);
  if (legs.size() % 2 != 0) return std::nullopt;
  Route shorter = route;
  for (std::size_t k = legs.size(); k >= 2; k -= 2) {
    const auto first = static_cast<std::ptrdiff_t>(legs[k - 2]) + 1;
    const auto last = static_cast<std::ptrdiff_t>(legs[k - 1]) + 1;
    shorter.waypoints.erase(shorter.waypoints.begin() + first, shorter.waypoints.begin() + last);
  }
  std::vector<Waypoint> kept;
  for (const Waypoint& w : shorter.waypoints) {
    if (kept.empty() || (kept.back().position - w.position).norm() > 0.05) kept.push_back(w);
  }
  shorter.waypoints = kept;
  if (kept.size() < 3 || 2 * kept.size() < route.waypoints.size()) return std::nullopt;
  return shorter;
}

Block leaf_of(const Wall& wall, const Opening& door) {
  constexpr double thickness = 0.04;
  const Eigen::Vector2d middle = wall.p + 0.5 * (door.begin + door.end) * wall.direction();
  Block leaf;
  leaf.name = "door";
  leaf.size = {door.end - door.begin, thickness, door.top - door.bottom};
  leaf.center = {middle.x(), middle.y(), wall.bottom + 0.5 * (door.bottom + door.top)};
  leaf.yaw = std::atan2(wall.direction().y(), wall.direction().x());
  leaf.material = Material::wood;
  leaf.line = wall.line;
  return leaf;
}

void close_doors(World& world, RandomStream& random, Session& session) {
  constexpr double share = 0.25;
  for (Storey& storey : world.storeys) {
    for (Wall& wall : storey.walls) {
      for (Opening& door : wall.openings) {
        if (door.pane || door.joins || door.bottom > 0.3 || door.end - door.begin > 1.6) continue;
        if (random.next_uniform() > share) continue;
        const std::optional<Route> shorter = without_door(world.route, wall, door);
        if (!shorter) continue;
        const Route before = world.route;
        world.route = *shorter;
        door.closed = true;
        storey.furniture.push_back(leaf_of(wall, door));
        if (possible(world)) {
          session.closed_doors.emplace_back(storey.furniture.back().center.head<2>());
        } else {
          world.route = before;
          door.closed = false;
          storey.furniture.pop_back();
        }
      }
    }
  }
}

void move_furniture(World& world, RandomStream& random, Session& session) {
  constexpr double share = 0.3;
  constexpr int attempts = 4;
  for (Storey& storey : world.storeys) {
    std::set<int> pieces;
    for (const Block& block : storey.furniture) {
      if (block.piece > 0) pieces.insert(block.piece);
    }
    for (const int piece : pieces) {
      const bool moves = random.next_uniform() < share;
      for (int i = 0; i < attempts; ++i) {
        const double direction = 2 * M_PI * random.next_uniform();
        const double distance = 0.3 + 0.7 * random.next_uniform();
        if (!moves) continue;
        const Eigen::Vector2d step = distance * Eigen::Vector2d(std::cos(direction), std::sin(direction));
        const std::vector<Block> before = storey.furniture;
        FurnitureMove move;
        bool first = true;
        for (Block& block : storey.furniture) {
          if (block.piece != piece) continue;
          if (first) move = {block.name, block.center.head<2>(), block.center.head<2>() + step};
          first = false;
          block.center.head<2>() += step;
        }
        if (furniture_fits(storey, piece) && possible(world)) {
          session.moved.push_back(move);
          break;
        }
        storey.furniture = before;
      }
    }
  }
}

}  // namespace

World with_session(const World& world, std::uint64_t seed) {
  World result = world;
  RandomStream random(seed, static_cast<std::uint64_t>(Stream::session));
  Session session;
  session.seed = seed;
  change_route(result, random);
  close_doors(result, random, session);
  move_furniture(result, random, session);
  check_routes_as_built(result);
  result.session = session;
  return result;
}

}  // namespace sgraph::sim
