#include "sgraph_slam/core/planes/align_storeys.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include <Eigen/Dense>

#include "sgraph_slam/core/planes/level_floors.hpp"
#include "sgraph_slam/core/planes/merging.hpp"
#include "sgraph_slam/core/types/storey.hpp"

namespace sgraph {
namespace {

constexpr double sigma = 0.015;      // [m] of walls above each other: they lean, and are built to a centimetre
constexpr double agree = 3 * sigma;  // [m]
constexpr double reach = 0.3;        // [m] the way up a stair or in a lift is known better than that; beyond it stands the other face of the wall
constexpr double along = 0.05;       // [rad]
constexpr double shortest = 1;       // [m] of wall above wall
constexpr double across = 0.5;       // sine between walls that hold both directions
constexpr std::size_t views = 3;     // of a wall
constexpr std::size_t longest = 40;  // walls above walls that a shift is looked for with; all count for it
constexpr double chance = 0.01;      // false alarms that are taken for none
constexpr double drawn = 0.05;       // [m] to which a floor of unknown height stays where it is drawn
constexpr double let_go = 2.5;       // of sigma

// A wall above a wall, and how far it is ahead of it at both ends of what they share.
struct Candidate {
  AlignedWalls walls;
  Eigen::Vector2d normal;
  Eigen::Vector2d ahead;

  [[nodiscard]] double length() const { return (walls.to - walls.from).norm(); }
  // Of the distances ahead, by a shift.
  [[nodiscard]] Eigen::Matrix<double, 2, 3> derivative(const Eigen::Vector2d& middle) const {
    Eigen::Matrix<double, 2, 3> J;
    for (int i = 0; i < 2; ++i) {
      const Eigen::Vector2d arm = (i == 0 ? walls.from : walls.to).head<2>() - middle;
      J.row(i) << normal.transpose(), normal.y() * arm.x() - normal.x() * arm.y();
    }
    return J;
  }
};

std::optional<Candidate> above(const PlaneMap& planes, const Wall& lower, const Wall& upper) {
  if (lower.normal.dot(upper.normal) < std::cos(along)) return std::nullopt;
  const Interval mine = hull(lower.support);
  const Interval its = hull(upper.support);
  const double p = lower.direction().dot(upper.at(its.low));
  const double q = lower.direction().dot(upper.at(its.high));
  const double begin = std::max(mine.low, std::min(p, q));
  const double end = std::min(mine.high, std::max(p, q));
  if (end - begin < shortest) return std::nullopt;
  const double height = planes.find(lower.id)->middle;
  const double rise = planes.find(upper.id)->middle - height;
  Candidate candidate;
  const Eigen::Vector2d from = lower.at(begin);
  const Eigen::Vector2d to = lower.at(end);
  candidate.walls = {lower.id, upper.id, {from.x(), from.y(), height}, {to.x(), to.y(), height}, rise, sigma, sigma};
  candidate.normal = lower.normal;
  candidate.ahead = -Eigen::Vector2d(upper.distance(from), upper.distance(to));
  if (candidate.ahead.cwiseAbs().maxCoeff() > reach) return std::nullopt;
  return candidate;
}

bool agrees(const Candidate& candidate, const Eigen::Vector3d& shift, const Eigen::Vector2d& middle) {
  return (candidate.ahead - candidate.derivative(middle) * shift).cwiseAbs().maxCoeff() <= agree;
}

struct Fit {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  std::size_t count = 0;
};

// The shift that fits those that agree with a first guess, and how many do.
std::optional<Fit> refined(const std::vector<Candidate>& candidates, const Eigen::Vector2d& middle, Eigen::Vector3d shift) {
  Fit fit;
  for (int round = 0; round < 3; ++round) {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    fit.count = 0;
    for (const Candidate& candidate : candidates) {
      if (!agrees(candidate, shift, middle)) continue;
      const Eigen::Matrix<double, 2, 3> J = candidate.derivative(middle);
      A += J.transpose() * J;
      b += J.transpose() * candidate.ahead;
      ++fit.count;
    }
    const Eigen::LDLT<Eigen::Matrix3d> solver(A);
    if (fit.count < 3 || solver.info() != Eigen::Success || solver.rcond() < 1e-6) return std::nullopt;
    shift = solver.solve(b);
  }
  fit.shift = shift;
  return fit;
}

// The first guess of two walls in different directions: the one gives the turn too.
std::optional<Eigen::Vector3d> guess(const Candidate& one, const Candidate& other, const Eigen::Vector2d& middle) {
  Eigen::Matrix3d A;
  Eigen::Vector3d b;
  A << one.derivative(middle), other.derivative(middle).colwise().mean();
  b << one.ahead, other.ahead.mean();
  const Eigen::FullPivLU<Eigen::Matrix3d> solver(A);
  if (!solver.isInvertible()) return std::nullopt;
  return solver.solve(b);
}

// Walls that lean would tell the height of a storey by where they stand, and it isn't known: so it stays where it is drawn, beside the other.
std::optional<AlignedWalls> at_one_height(const Graph& graph, const PlaneMap& planes, int lower, int upper) {
  const std::optional<PlaneId> below = largest_floor(graph, planes, lower);
  const std::optional<PlaneId> above = largest_floor(graph, planes, upper);
  if (!below || !above) return std::nullopt;
  const Eigen::Vector3d middle = outline_center(planes.find(*above)->outline);
  return at_height(*below, *above, middle, 0, drawn);
}

// Probability that at least k of n walls agree, each with probability p.
double at_least(std::size_t k, std::size_t n, double p) {
  double sum = 0;
  for (std::size_t i = k; i <= n; ++i) {
    const auto total = static_cast<double>(n);
    const auto hits = static_cast<double>(i);
    sum += std::exp(std::lgamma(total + 1) - std::lgamma(hits + 1) - std::lgamma(total - hits + 1) + hits * std::log(p) +
                    (total - hits) * std::log1p(-p));
  }
  return sum;
}

// Looks for the shift under which walls of one storey stand above walls of another, and returns those that agree with it. None when as many could
// agree by chance, or all run in one direction.
std::vector<AlignedWalls> walls_on_walls(const PlaneMap& planes, int lower, int upper) {
  std::vector<Candidate> candidates;
  const std::vector<Wall> below = planes.walls(views, 0, lower);
  for (const Wall& wall : planes.walls(views, 0, upper)) {
    for (const Wall& other : below) {
      if (const auto candidate = above(planes, other, wall)) candidates.push_back(*candidate);
    }
  }
  if (candidates.size() < 4) return {};
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Candidate& candidate : candidates) middle += 0.5 * (candidate.walls.from + candidate.walls.to).head<2>();
  middle /= static_cast<double>(candidates.size());
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.length() > b.length(); });

  Fit best;
  std::size_t tried = 0;
  const std::size_t most = std::min(candidates.size(), longest);
  for (std::size_t i = 0; i < most; ++i) {
    for (std::size_t j = 0; j < most; ++j) {
      const Eigen::Vector2d& n = candidates[i].normal;
      const Eigen::Vector2d& m = candidates[j].normal;
      if (std::abs(n.x() * m.y() - n.y() * m.x()) < across) continue;
      ++tried;
      const auto first = guess(candidates[i], candidates[j], middle);
      const auto fit = first ? refined(candidates, middle, *first) : std::nullopt;
      if (fit && fit->count > best.count) best = *fit;
    }
  }
  if (best.count < 3) return {};
  // Two walls make any shift; the others lie within reach of each other wherever they like.
  const double false_alarms = static_cast<double>(tried) * at_least(best.count - 2, candidates.size() - 2, agree / reach);
  if (false_alarms > chance) return {};
  std::vector<AlignedWalls> walls;
  for (const Candidate& candidate : candidates) {
    if (agrees(candidate, best.shift, middle)) walls.push_back(candidate.walls);
  }
  return walls;
}

}  // namespace

int align_storeys(Committer& committer, const PlaneMap& planes, const std::vector<int>& height_groups) {
  const auto group = [&height_groups](int storey) {
    const auto k = static_cast<std::size_t>(storey);
    return k < height_groups.size() ? height_groups[k] : 0;
  };
  std::map<int, std::map<PlanePair, FactorId>> joined;  // by the upper storey
  const std::set<int> storeys = storeys_of(planes);
  if (storeys.size() < 2) return 0;
  Transaction edit;
  edit.reason = "walls stand on walls";
  for (const auto& [id, factor] : committer.graph.factors()) {
    const auto* walls = std::get_if<AlignedWalls>(&factor.data);
    if (walls == nullptr || are_floors_apart(*walls)) continue;
    const PlaneRecord* lower = planes.find(walls->a);
    const PlaneRecord* upper = planes.find(walls->b);
    if (lower == nullptr || upper == nullptr || lower->storey == stairwell || upper->storey == stairwell) continue;
    if (lower->storey < upper->storey) {
      joined[upper->storey][{walls->a, walls->b}] = id;
    } else {
      edit.remove_factors.push_back(id);  // what was a storey of its own has been recognised
    }
  }
  for (const int upper : storeys) {
    int below = 0;
    std::vector<AlignedWalls> best;
    for (const int lower : storeys) {
      if (lower >= upper) break;
      std::vector<AlignedWalls> walls = walls_on_walls(planes, lower, upper);
      if (walls.size() <= best.size()) continue;
      below = lower;
      best = std::move(walls);
    }
    if (best.empty()) continue;
    if (group(below) != group(upper)) {
      if (const auto floors = at_one_height(committer.graph, planes, below, upper)) best.push_back(*floors);
    }
    std::map<PlanePair, FactorId>& before = joined[upper];
    for (const AlignedWalls& walls : best) {
      if (before.erase({walls.a, walls.b}) == 0) add_factor(edit, walls, RobustLoss::huber(let_go));
    }
    for (const auto& [pair, factor] : before) edit.remove_factors.push_back(factor);
  }
  const auto changes = static_cast<int>(edit.factors.size() + edit.remove_factors.size());
  return changes == 0 || !committer.commit(edit).ok() ? 0 : changes;
}

}  // namespace sgraph
