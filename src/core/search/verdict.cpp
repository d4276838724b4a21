#include "sgraph_slam/core/search/verdict.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include <Eigen/LU>

namespace sgraph {
namespace {

// Lengths of wall [m].
constexpr double least_total = 14;          // seen at all
constexpr double least_matched = 0.72;      // share of it
constexpr double most_contradicted = 0.10;  // share of it, beside
constexpr double allowed = 0.8;             // a door leaf
constexpr double least_spread = 3;          // of walls across the direction that has least of them
constexpr double least_lead = 1.6;          // how much more must speak against any other place

bool stands(const LayoutFit& fit) { return fit.matched >= least_matched * fit.total && fit.contradicted <= most_contradicted * fit.total + allowed; }

// Whether a place cannot be ruled out: less than this speaks against it.
bool possible(const LayoutFit& fit, const LayoutFit& best) { return fit.cost() < best.cost() + least_lead; }

// Walls that hold the position across the direction in which it is held least [m].
double spread_of(const Layout& layout) {
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const WallSample& s : layout.samples()) {
    if (s.solid) sum += WallSample::spacing * s.normal * s.normal.transpose();
  }
  const double mean = 0.5 * sum.trace();
  return mean - std::sqrt(std::max(0.0, mean * mean - sum.determinant()));
}

}  // namespace

PlaceVerdict judge_places(const PlaceSearchResult& places, const Layout& query, double share) {
  PlaceVerdict verdict;
  if (places.hypotheses.empty()) return verdict;
  const LayoutFit& best = places.hypotheses.front().fit;
  verdict.stands = stands(best);
  for (const PlaceHypothesis& place : places.hypotheses) verdict.possible += possible(place.fit, best) ? 1 : 0;
  if (!places.exhaustive) ++verdict.possible;  // there is at least one that was not looked at
  verdict.enough = best.total >= share * least_total && spread_of(query) >= share * least_spread;
  return verdict;
}

std::string to_string(const LayoutFit& fit) {
  std::array<char, 160> words{};
  std::snprintf(words.data(), words.size(), "%.1f m of wall: %.1f match, %.1f unknown, %.1f contradict", fit.total, fit.matched, fit.unknown,
                fit.contradicted);
  return words.data();
}

}  // namespace sgraph
