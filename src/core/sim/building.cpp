#include <algorithm>
#include <cmath>
#include <optional>

#include "plan.hpp"
#include "regions.hpp"
#include "route_check.hpp"
#include "sgraph_slam/core/sim/motion.hpp"
#include "sgraph_slam/core/sim/world.hpp"
#include "sgraph_slam/core/util/rng.hpp"
#include "streams.hpp"

namespace sgraph::sim {

namespace {

constexpr double touching = 0.03;  // ends of walls this near to each other or to a centre line are joined there [m]

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

Eigen::Vector2d left_of(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

// The line on which a wall's centre stands, before and after.
struct Line {
  Eigen::Vector2d middle;
  Eigen::Vector2d direction;
  Eigen::Vector2d turned;
  double shift = 0;  // across

  [[nodiscard]] Eigen::Vector2d moved(const Eigen::Vector2d& p) const {
    return middle + shift * left_of(direction) + turned * (p - middle).dot(direction);
  }
};

// Numbers of the walls that are pieces of one straight wall: end to end, in one direction, of one storey.
std::vector<std::size_t> straight_runs(const std::vector<Wall>& walls) {
  std::vector<std::size_t> run(walls.size());
  for (std::size_t i = 0; i < walls.size(); ++i) run[i] = i;
  const auto root = [&run](std::size_t i) {
    while (run[i] != i) i = run[i];
    return i;
  };
  for (std::size_t i = 0; i < walls.size(); ++i) {
    for (std::size_t k = i + 1; k < walls.size(); ++k) {
      const Wall& a = walls[i];
      const Wall& b = walls[k];
      if (std::abs(cross(a.direction(), b.direction())) > 0.01) continue;
      if (std::abs(cross(a.direction(), b.p - a.p)) > 0.01) continue;
      const double gap = std::min({(a.p - b.p).norm(), (a.p - b.q).norm(), (a.q - b.p).norm(), (a.q - b.q).norm()});
      if (gap < touching) run[std::max(root(i), root(k))] = std::min(root(i), root(k));
    }
  }
  for (std::size_t i = 0; i < walls.size(); ++i) run[i] = root(i);
  return run;
}

// Where a wall's end goes: to where its line meets that of the wall that it joins; where nothing joins it, with its line.
Eigen::Vector2d moved_end(const std::vector<Wall>& walls, const std::vector<Line>& lines, std::size_t wall, bool at_p) {
  constexpr double least_sine = 0.3;  // lines that meet at a flatter angle meet too far off for a small turn
  const Eigen::Vector2d end = at_p ? walls[wall].p : walls[wall].q;
  const Line& own = lines[wall];
  std::optional<Eigen::Vector2d> corner;
  std::optional<Eigen::Vector2d> abutment;
  Eigen::Vector2d sum = own.moved(end);
  int count = 1;
  for (std::size_t k = 0; k < walls.size(); ++k) {
    if (k == wall) continue;
    const Wall& other = walls[k];
    const Eigen::Vector2d offset = end - other.p;
    const double along = offset.dot(other.direction());
    const bool is_corner = std::min((end - other.p).norm(), (end - other.q).norm()) < touching;
    const bool abuts = std::abs(cross(other.direction(), offset)) < 0.5 * other.thickness + touching && along > 0 && along < other.length();
    if (!is_corner && !abuts) continue;
    const double sine = cross(own.turned, lines[k].turned);
    if (std::abs(sine) > least_sine) {
      const Eigen::Vector2d from = own.moved(end);
      const Eigen::Vector2d on_other = lines[k].moved(end);
      // Where it abuts it ends as far from the other's centre line as before.
      const double before = is_corner ? 0 : cross(end - other.p, lines[k].direction);
      const Eigen::Vector2d meeting = from + own.turned * (cross(on_other - from, lines[k].turned) + before) / sine;
      std::optional<Eigen::Vector2d>& place = is_corner ? corner : abutment;
      if (!place) place = meeting;
    } else if (is_corner) {
      sum += lines[k].moved(end);
      ++count;
    }
  }
  if (corner) return *corner;
  if (abutment) return *abutment;
  return sum / count;
}

void move_walls(Storey& storey, const BuildingErrors& errors, RandomStream& random) {
  const std::vector<Wall> planned = storey.walls;
  const std::vector<std::size_t> run = straight_runs(planned);
  const auto signed_share = [&random] { return std::max(-1.0, std::min(1.0, 0.5 * random.next_normal())); };
  std::vector<Line> lines(planned.size());
  for (std::size_t i = 0; i < planned.size(); ++i) {
    const double turn_share = signed_share();
    const double shift_share = signed_share();
    storey.walls[i].lean = std::tan(errors.lean) * signed_share();
    const double bow_share = signed_share();
    storey.walls[i].bow = errors.bow * bow_share * std::min(1.0, planned[i].length() / 3);  // short ones have less
    if (run[i] != i) {
      lines[i] = lines[run[i]];
      storey.walls[i].lean = storey.walls[run[i]].lean;
      if (planned[i].direction().dot(lines[i].direction) < 0) storey.walls[i].lean *= -1;
      storey.walls[i].bow = 0;
      continue;
    }
    // The ends of the whole run, from its first piece's point of view.
    const Eigen::Vector2d direction = planned[i].direction();
    double begin = 0;
    double end = 0;
    for (std::size_t k = i; k < planned.size(); ++k) {
      if (run[k] != i) continue;
      for (const Eigen::Vector2d& p : {planned[k].p, planned[k].q}) {
        begin = std::min(begin, (p - planned[i].p).dot(direction));
        end = std::max(end, (p - planned[i].p).dot(direction));
      }
      if (k != i) storey.walls[i].bow = 0;
    }
    const double half = 0.5 * (end - begin);
    const double turn = turn_share * std::min(errors.square, errors.shift / half);
    Line line;
    line.middle = planned[i].p + 0.5 * (begin + end) * direction;
    line.direction = direction;
    line.turned = Eigen::Rotation2Dd(turn) * direction;
    line.shift = shift_share * (errors.shift - std::abs(turn) * half);
    lines[i] = line;
  }
  for (std::size_t i = 0; i < planned.size(); ++i) {
    storey.walls[i].p = moved_end(planned, lines, i, true);
    storey.walls[i].q = moved_end(planned, lines, i, false);
    // Openings keep their place along the wall as near as they can; the last one stays on it.
    const double before = planned[i].length();
    const double now = storey.walls[i].length();
    if (now < 0.01) throw WorldError("the building's errors leave nothing of a wall of " + std::to_string(before) + " m");
    const double moved = (planned[i].p - storey.walls[i].p).dot(storey.walls[i].direction());
    for (Opening& opening : storey.walls[i].openings) {
      const double width = opening.end - opening.begin;
      opening.begin = std::max(0.0, std::min(opening.begin + moved, now - width));
      opening.end = opening.begin + width;
    }
  }
}

Unevenness uneven(const std::vector<std::vector<Eigen::Vector2d>>& outlines, const BuildingErrors& errors, RandomStream& random) {
  Unevenness shape;
  Eigen::Vector2d low(1e9, 1e9);
  Eigen::Vector2d high(-1e9, -1e9);
  for (const auto& outline : outlines) {
    for (const Eigen::Vector2d& p : outline) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  shape.origin = 0.5 * (low + high);
  const double fall = 2 * M_PI * random.next_uniform();
  const double steep = errors.slope * (0.5 + 0.5 * random.next_uniform());
  shape.slope = steep * Eigen::Vector2d(std::cos(fall), std::sin(fall));
  for (int i = 0; i < 3; ++i) {  // waves of 3 to 9 m that together reach the given height from trough to crest
    const double heading = 2 * M_PI * random.next_uniform();
    const double number = 2 * M_PI / (3 + 6 * random.next_uniform());
    const double phase = 2 * M_PI * random.next_uniform();
    if (errors.undulation > 0) shape.waves.push_back({number * Eigen::Vector2d(std::cos(heading), std::sin(heading)), phase, errors.undulation / 6});
  }
  return shape;
}

// Measures a room anew between the walls as they stand; its axes are the mean of its four walls'.
void measure_again(const Storey& storey, std::vector<Place>& places) {
  for (Place& place : places) {
    std::string error;
    const std::optional<Place> found = place_between_walls(storey, place.center, place.yaw, error);
    if (!found) throw WorldError(place.name + " with the building's errors: " + error);
    place.center = found->center;
    place.width = found->width;
  }
}

}  // namespace

bool stands_on(const Storey& above, const Storey& below) { return std::abs(below.elevation + below.height - above.elevation) < 1e-3; }

double Unevenness::operator()(const Eigen::Vector2d& at) const {
  double z = slope.dot(at - origin);
  for (const Wave& wave : waves) z += wave.amplitude * std::sin(wave.number.dot(at) + wave.phase);
  return z;
}

World with_building_errors(const World& world) {
  World result = world;
  for (std::size_t k = 0; k < world.storeys.size(); ++k) {
    Storey& storey = result.storeys[k];
    RandomStream random(world.errors.seed + 1000 * k, static_cast<std::uint64_t>(Stream::building));
    move_walls(storey, world.errors, random);
    storey.floor_shape = uneven(storey.outlines, world.errors, random);
    storey.ceiling_shape = uneven(storey.outlines, world.errors, random);
    for (auto* blocks : {&storey.columns, &storey.furniture}) {
      for (Block& block : *blocks) block.center.z() += storey.floor_shape(block.center.head<2>());
    }
    measure_again(storey, storey.rooms);
    measure_again(storey, storey.corridors);
    storey.regions = regions_of(storey, world.file);
  }
  // Where a floor lies on the ceiling below, both are sides of one slab without thickness.
  for (Storey& below : result.storeys) {
    for (const Storey& above : result.storeys) {
      if (stands_on(above, below)) below.ceiling_shape = above.floor_shape;
    }
  }
  check_routes_as_built(result);
  return result;
}

}  // namespace sgraph::sim
