#include "hypotheses.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "sgraph_slam/core/segmentation/plane_fit.hpp"

namespace sgraph {
namespace {

struct Level {
  float edge;                  // of a cell; a neighbourhood is two cells wide [m]
  float min_range, max_range;  // of its seeds [m]
};
constexpr std::array<Level, 3> levels{{{0.4F, 0.0F, 6.0F}, {0.8F, 6.0F, 12.0F}, {1.6F, 12.0F, std::numeric_limits<float>::infinity()}}};
constexpr std::size_t neighbourhood_limit = 64;
constexpr int triples = 8;
constexpr float flat = 0.1F;  // a neighbourhood's rms is below this [m]

// Points by cubic cell: a hash of cells, and the points of each cell in a row.
class CellIndex {
 public:
  CellIndex(const PointSet& points, float edge) : scale_(1.0F / edge) {
    std::size_t size = 64;
    while (size < 2 * points.size()) {
      size *= 2;
      --shift_;
    }
    table_.assign(size, -1);
    std::vector<std::uint32_t> cell_of(points.size());
    std::vector<std::uint32_t> count;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::size_t slot = find(key(points.position(i), 0, 0, 0));
      if (table_[slot] < 0) {
        table_[slot] = static_cast<int>(keys_.size());
        keys_.push_back(key(points.position(i), 0, 0, 0));
        count.push_back(0);
      }
      cell_of[i] = static_cast<std::uint32_t>(table_[slot]);
      ++count[cell_of[i]];
    }
    first_.assign(count.size() + 1, 0);
    for (std::size_t c = 0; c < count.size(); ++c) first_[c + 1] = first_[c] + count[c];
    members_.resize(points.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < points.size(); ++i) members_[next[cell_of[i]]++] = static_cast<std::uint32_t>(i);
  }

  [[nodiscard]] std::size_t cells() const { return keys_.size(); }
  [[nodiscard]] std::uint32_t count(std::size_t cell) const { return first_[cell + 1] - first_[cell]; }
  [[nodiscard]] std::uint32_t member(std::size_t cell, std::size_t k) const { return members_[first_[cell] + k]; }

  /// Points of the eight cells around the corner nearest p.
  void around(const Eigen::Vector3f& p, std::vector<std::uint32_t>& out) const {
    out.clear();
    const Eigen::Vector3f shifted = p.array() * scale_ - 0.5F;
    const Eigen::Vector3f corner = shifted.array().floor() + 0.5F;
    for (int k = 0; k < 8; ++k) {
      const Eigen::Vector3f q = corner / scale_;
      const std::size_t slot = find(key(q, k & 1, k >> 1 & 1, k >> 2));
      if (table_[slot] < 0) continue;
      const auto cell = static_cast<std::size_t>(table_[slot]);
      out.insert(out.end(), members_.begin() + first_[cell], members_.begin() + first_[cell + 1]);
    }
  }

 private:
  [[nodiscard]] std::uint64_t key(const Eigen::Vector3f& p, int dx, int dy, int dz) const {
    const auto axis = [this](float value, int step) {
      const float cell = std::min(std::max(std::floor(value * scale_), -1e6F), 1e6F);
      return static_cast<std::uint64_t>(static_cast<int>(cell) + step + (1 << 20)) & ((1U << 21) - 1);
    };
    return axis(p.x(), dx) << 42 | axis(p.y(), dy) << 21 | axis(p.z(), dz);
  }
  [[nodiscard]] std::size_t find(std::uint64_t wanted) const {
    std::size_t slot = (wanted * 0x9E3779B97F4A7C15ULL) >> shift_;
    while (table_[slot] >= 0 && keys_[static_cast<std::size_t>(table_[slot])] != wanted) slot = (slot + 1) & (table_.size() - 1);
    return slot;
  }

  float scale_;
  int shift_ = 64 - 6;
  std::vector<int> table_;
  std::vector<std::uint64_t> keys_;
  std::vector<std::uint32_t> first_, members_;
};

// One random seed point in each of up to `count` cells of the level.
std::vector<std::uint32_t> seeds(const PointSet& points, const CellIndex& cells, const Level& level, std::size_t count, RandomStream& random) {
  std::vector<std::uint32_t> chosen;
  for (std::size_t c = 0; c < cells.cells(); ++c) {
    const std::uint32_t seed = cells.member(c, draw(random, cells.count(c)));
    const float range = points.position(seed).norm();
    if (range >= level.min_range && range < level.max_range) chosen.push_back(seed);
  }
  for (std::size_t i = 0; i + 1 < chosen.size() && i < count; ++i) std::swap(chosen[i], chosen[i + draw(random, chosen.size() - i)]);
  if (chosen.size() > count) chosen.resize(count);
  return chosen;
}

// Plane through three of the points for which half of all points lie nearest; returns that median distance.
float least_median_plane(const PointSet& points, const std::vector<std::uint32_t>& which, RandomStream& random, PlaneF& best) {
  float best_median = std::numeric_limits<float>::infinity();
  std::vector<float> distances(which.size());
  for (int trial = 0; trial < triples; ++trial) {
    const Eigen::Vector3f a = points.position(which[draw(random, which.size())]);
    const Eigen::Vector3f b = points.position(which[draw(random, which.size())]);
    const Eigen::Vector3f c = points.position(which[draw(random, which.size())]);
    PlaneF plane;
    plane.normal = (b - a).cross(c - a);
    const float area = plane.normal.norm();
    if (area < 0.01F) continue;  // [m^2]: nearly on a line, the noise would turn the plane
    plane.normal /= area;
    plane.d = -plane.normal.dot(a);
    for (std::size_t i = 0; i < which.size(); ++i) distances[i] = std::abs(points.distance(plane, which[i]));
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    if (*middle < best_median) {
      best_median = *middle;
      best = plane;
    }
  }
  return best_median;
}

// Plane of the majority of the points, which are cut down to it.
PlaneFit fit_majority(const PointSet& points, std::vector<std::uint32_t>& which, RandomStream& random) {
  const PlaneFit all = fit_plane(scatter_of(points, which));
  if (all.valid && all.spread[0] < 0.25 * flat && all.spread[0] < 0.2 * all.spread[1]) return all;
  PlaneF plane;
  const float median = least_median_plane(points, which, random, plane);
  if (!(median < flat)) return {};
  const float limit = std::max(0.01F, 2.5F * 1.4826F * median);
  which.erase(std::remove_if(which.begin(), which.end(), [&](std::uint32_t i) { return std::abs(points.distance(plane, i)) > limit; }), which.end());
  return fit_plane(scatter_of(points, which));
}

bool hypothesis_at(const PointSet& points, std::vector<std::uint32_t>& which, const std::vector<Eigen::Vector3f>& viewpoints, float edge,
                   RandomStream& random, Hypothesis& result) {
  if (which.size() < 8) return false;
  if (which.size() > neighbourhood_limit) {
    for (std::size_t i = 0; i < neighbourhood_limit; ++i) which[i] = which[i * which.size() / neighbourhood_limit];
    which.resize(neighbourhood_limit);
  }
  const PlaneFit fit = fit_majority(points, which, random);
  // A single stripe, bent by noise, holds no normal.
  if (!fit.valid || which.size() < 8 || fit.spread[0] > flat || fit.spread[1] < 0.15 * edge || fit.spread[0] > 0.3 * fit.spread[1]) return false;
  result.plane = PlaneF(fit.plane);
  result.centroid = fit.centroid.cast<float>();
  float towards = 0;
  float length = 0;
  for (const std::uint32_t i : which) {
    const Eigen::Vector3f ray = viewpoints[points.view[i]] - points.position(i);
    towards += result.plane.normal.dot(ray);
    length += ray.norm();
  }
  if (towards < 0) {
    result.plane.normal = -result.plane.normal;
    result.plane.d = -result.plane.d;
  }
  const auto n = static_cast<float>(which.size());
  result.rms = static_cast<float>(fit.spread[0]) * std::sqrt(n / (n - 3));
  result.cosine = std::abs(towards) / std::max(length, 1e-6F);
  return true;
}

}  // namespace

std::vector<Hypothesis> sample_hypotheses(const PointSet& points, const std::vector<Eigen::Vector3f>& viewpoints, int count, RandomStream& random) {
  std::vector<Hypothesis> hypotheses;
  std::vector<std::uint32_t> near;
  std::array<std::size_t, levels.size()> in_level{};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const float range = points.position(i).norm();
    for (std::size_t l = 0; l < levels.size(); ++l) in_level[l] += range >= levels[l].min_range && range < levels[l].max_range ? 1U : 0U;
  }
  for (std::size_t l = 0; l < levels.size(); ++l) {
    if (in_level[l] == 0) continue;
    const CellIndex cells(points, levels[l].edge);
    const std::size_t share = (static_cast<std::size_t>(count) * in_level[l] + points.size() - 1) / points.size();
    for (const std::uint32_t seed : seeds(points, cells, levels[l], share, random)) {
      cells.around(points.position(seed), near);
      Hypothesis hypothesis;
      if (hypothesis_at(points, near, viewpoints, levels[l].edge, random, hypothesis)) hypotheses.push_back(hypothesis);
    }
  }
  return hypotheses;
}

double estimate_noise(const std::vector<Hypothesis>& hypotheses, double fallback) {
  std::vector<float> rms;
  for (const Hypothesis& h : hypotheses) {
    if (h.cosine > 0.7F) rms.push_back(h.rms);
  }
  if (rms.size() < 20) {
    rms.clear();
    for (const Hypothesis& h : hypotheses) rms.push_back(h.rms);
  }
  if (rms.empty()) return fallback;
  const auto middle = rms.begin() + static_cast<std::ptrdiff_t>(rms.size() / 2);
  std::nth_element(rms.begin(), middle, rms.end());
  return *middle;
}

}  // namespace sgraph
