#include "sgraph_slam/core/search/place_search.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <tuple>

namespace sgraph {
namespace {

constexpr int directions = 16;             // bits of a mask
constexpr std::size_t level_count = 7;     // cells of 0.1 to 6.4 m
constexpr double most_map_cells = 9e6;     // a larger map has larger cells
constexpr double tolerance = 0.15;         // of a wall in the coarse search [m]
constexpr std::size_t most_samples = 240;  // of the query in the coarse search
constexpr double least_share = 0.5;        // of the samples on walls, for a hypothesis
constexpr double near_best = 0.7;          // hypotheses with less than this share of the best score are of no interest
constexpr std::size_t most_hypotheses = 24;
constexpr int most_nodes = 400'000;
constexpr double same_place = 0.7;     // [m] of two hypotheses that are one
constexpr double same_heading = 0.1;   // [rad]
constexpr double least_heading = 0.4;  // of the best agreement of the walls' directions

// In the fine comparison.
constexpr double matched_across = 0.06;    // [m] of a wall from the map's: what maps and fits are wrong by
constexpr double beside = 0.45;            // [m] a face as far beside one of the map contradicts it
constexpr double parallel = 0.985;         // cosine of 10 degrees
constexpr double longer_than_door = 1.35;  // [m]

int direction_of(double angle) {
  const double turns = angle / (2 * M_PI);
  return static_cast<int>(std::floor((turns - std::floor(turns)) * directions)) % directions;
}

std::uint16_t bit(int direction) { return static_cast<std::uint16_t>(1U << ((direction + directions) % directions)); }

// The bits of the directions within a bin's width.
std::uint16_t bits_around(const Eigen::Vector2d& normal) {
  const double angle = std::atan2(normal.y(), normal.x());
  const double half = M_PI / directions;
  return static_cast<std::uint16_t>(bit(direction_of(angle)) | bit(direction_of(angle - half)) | bit(direction_of(angle + half)));
}

double wrapped(double angle) { return std::remainder(angle, 2 * M_PI); }

// A query seen at one heading: cells of its samples and their directions.
struct Turned {
  double yaw = 0;
  std::vector<Eigen::Vector2i> cells;
  std::vector<std::uint16_t> masks;
  Eigen::Vector2i low = Eigen::Vector2i::Zero();  // first offset of the query's origin [cells]
  Eigen::Vector2i high = Eigen::Vector2i::Zero();
};

struct Node {
  int score;
  std::size_t heading;
  int x, y;  // least offset [cells]
  std::size_t level;

  // The best first; among equals the finer, then a fixed order.
  friend bool operator<(const Node& a, const Node& b) {
    if (a.score != b.score) return a.score < b.score;
    if (a.level != b.level) return a.level > b.level;
    return std::tie(a.heading, a.x, a.y) > std::tie(b.heading, b.x, b.y);
  }
};

std::vector<WallSample> thinned(const std::vector<WallSample>& samples) {
  if (samples.size() <= most_samples) return samples;
  std::vector<WallSample> few;
  for (std::size_t i = 0; i < most_samples; ++i) few.push_back(samples[i * samples.size() / most_samples]);
  return few;
}

void add_to_histogram(const Eigen::Vector2d& normal, double length, std::vector<double>& histogram) {
  const double degrees = std::atan2(normal.y(), normal.x()) * 180 / M_PI;
  for (int k = -3; k <= 3; ++k) {  // a triangle of three degrees
    const int bin = (static_cast<int>(std::floor(degrees)) + k + 720) % 360;
    histogram[static_cast<std::size_t>(bin)] += length * (1 - std::abs(k) / 4.0);
  }
}

// Length of the samples that belong to pieces longer than a door.
double length_of_long_pieces(const std::vector<WallSample>& samples) {
  double length = 0;
  for (const auto& piece : joined_pieces(samples)) {
    const double piece_length = WallSample::spacing * static_cast<double>(piece.size());
    if (piece_length >= longer_than_door) length += piece_length;
  }
  return length;
}

}  // namespace

PlaceSearch::PlaceSearch(Layout map) : map_(std::move(map)), index_(map_), histogram_(360, 0.0) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d high = -low;
  for (const WallSample& sample : map_.samples()) {
    low = low.cwiseMin(sample.point);
    high = high.cwiseMax(sample.point);
    add_to_histogram(sample.normal, WallSample::spacing, histogram_);
  }
  if (map_.samples().empty()) return;
  origin_ = low - Eigen::Vector2d::Constant(0.5);
  Eigen::Vector2d size = high + Eigen::Vector2d::Constant(0.5) - origin_;
  while (size.x() * size.y() / (resolution_ * resolution_) > most_map_cells) resolution_ *= 2;
  width_ = static_cast<int>(size.x() / resolution_) + 1;
  height_ = static_cast<int>(size.y() / resolution_) + 1;
  levels_.resize(level_count);
  levels_[0].cells.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
  const int reach = static_cast<int>(std::ceil(tolerance / resolution_));
  for (const WallPiece& piece : map_.pieces()) {
    const double length = (piece.to - piece.from).norm();
    const int steps = 1 + static_cast<int>(std::ceil(length / (0.7 * resolution_)));
    const Mask mask = bits_around(piece.normal);
    for (int s = 0; s <= steps; ++s) {
      const Eigen::Vector2d p = piece.from + static_cast<double>(s) / steps * (piece.to - piece.from);
      for (int k = -reach; k <= reach; ++k) {
        const Eigen::Vector2i c = ((p + k * 0.9 * tolerance / reach * piece.normal - origin_) / resolution_).array().floor().cast<int>();
        if (c.x() < 0 || c.y() < 0 || c.x() >= width_ || c.y() >= height_) continue;
        levels_[0].cells[static_cast<std::size_t>(c.y()) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(c.x())] |= mask;
      }
    }
  }
  for (std::size_t level = 1; level < level_count; ++level) {
    const int half = 1 << (level - 1);
    levels_[level].cells.resize(levels_[0].cells.size());
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        levels_[level].cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)] =
            static_cast<Mask>(at(level - 1, x, y) | at(level - 1, x + half, y) | at(level - 1, x, y + half) | at(level - 1, x + half, y + half));
      }
    }
  }
}

std::vector<double> PlaceSearch::headings(const std::vector<WallSample>& samples, double step) const {
  std::vector<double> own(360, 0.0);
  for (const WallSample& sample : samples) add_to_histogram(sample.normal, WallSample::spacing, own);
  std::vector<double> agreement(360, 0.0);
  for (std::size_t turn = 0; turn < 360; ++turn) {
    // The lesser of the two: a direction counts as far as both have it.
    for (std::size_t i = 0; i < 360; ++i) agreement[turn] += std::min(own[i], histogram_[(i + turn) % 360]);
  }
  const double best = *std::max_element(agreement.begin(), agreement.end());
  std::vector<double> headings;
  const int count = std::max(90, static_cast<int>(std::ceil(2 * M_PI / step)));
  for (int i = 0; i < count; ++i) {
    const double yaw = 2 * M_PI * i / count;
    const auto degree = static_cast<std::size_t>(std::lround(yaw * 180 / M_PI)) % 360;
    if (agreement[degree] >= least_heading * best) headings.push_back(yaw);
  }
  return headings;
}

PlaceSearchResult PlaceSearch::find(const Layout& query) const {
  PlaceSearchResult result;
  if (levels_.empty() || query.samples().empty()) return result;
  const std::vector<WallSample> samples = thinned(query.samples());
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  for (const WallSample& s : samples) center += s.point / static_cast<double>(samples.size());
  double radius = 1;
  for (const WallSample& s : samples) radius = std::max(radius, (s.point - center).norm());

  std::vector<Turned> turned;
  for (const double yaw : headings(samples, 1.2 * tolerance / radius)) {
    Turned& t = turned.emplace_back();
    t.yaw = yaw;
    const Pose2d turn{Eigen::Vector2d::Zero(), yaw};
    const Eigen::Matrix2d R = turn.matrix();
    for (const WallSample& s : samples) {
      const Eigen::Vector2i cell = (R * (s.point - center) / resolution_).array().floor().cast<int>();
      t.cells.push_back(cell);
      const Eigen::Vector2d normal = R * s.normal;
      t.masks.push_back(bit(direction_of(std::atan2(normal.y(), normal.x()))));
    }
    // The query's centre lies within the map, or as far outside as half of the walls may.
    const int outside = static_cast<int>(0.5 * radius / resolution_);
    t.low = Eigen::Vector2i::Constant(-outside);
    t.high = Eigen::Vector2i(width_ + outside, height_ + outside);
  }

  const auto score = [&](const Turned& t, int x, int y, std::size_t level) {
    int hits = 0;
    for (std::size_t i = 0; i < t.cells.size(); ++i) hits += (at(level, t.cells[i].x() + x, t.cells[i].y() + y) & t.masks[i]) != 0;
    return hits;
  };
  // At the coarsest level a cell may begin before the grid does; `at` knows no cells there, so such nodes are split without a bound.
  const auto bound = [&](const Turned& t, int x, int y, std::size_t level) {
    if (level == 0) return score(t, x, y, 0);
    const int span = (1 << level) - 1;
    int hits = 0;
    for (std::size_t i = 0; i < t.cells.size(); ++i) {
      const int cx = t.cells[i].x() + x;
      const int cy = t.cells[i].y() + y;
      if (cx + span < 0 || cy + span < 0 || cx >= width_ || cy >= height_) continue;
      hits += cx < 0 || cy < 0 || (at(level, cx, cy) & t.masks[i]) != 0;
    }
    return hits;
  };

  const auto least = static_cast<int>(std::ceil(least_share * static_cast<double>(samples.size())));
  std::priority_queue<Node> open;
  const std::size_t top = level_count - 1;
  for (std::size_t h = 0; h < turned.size(); ++h) {
    for (int y = turned[h].low.y(); y < turned[h].high.y(); y += 1 << top) {
      for (int x = turned[h].low.x(); x < turned[h].high.x(); x += 1 << top) {
        const int hits = bound(turned[h], x, y, top);
        if (hits >= least) open.push({hits, h, x, y, top});
      }
    }
  }
  struct Peak {
    Eigen::Vector2d center;
    double yaw;
  };
  std::vector<Peak> peaks;
  int best = 0;
  for (int nodes = 0; !open.empty(); ++nodes) {
    if (nodes >= most_nodes || peaks.size() >= most_hypotheses) {
      result.exhaustive = false;
      break;
    }
    const Node node = open.top();
    open.pop();
    if (node.score < near_best * best) break;
    const Turned& t = turned[node.heading];
    const double half = 0.5 * resolution_ * (1 << node.level);
    const Eigen::Vector2d middle = origin_ + resolution_ * Eigen::Vector2d(node.x, node.y) + Eigen::Vector2d::Constant(half);
    const bool known = std::any_of(peaks.begin(), peaks.end(), [&](const Peak& p) {
      return (middle - p.center).cwiseAbs().maxCoeff() + half < same_place && std::abs(wrapped(t.yaw - p.yaw)) < same_heading;
    });
    if (known) continue;
    if (node.level == 0) {
      best = std::max(best, node.score);
      peaks.push_back({middle, t.yaw});
      continue;
    }
    const int step = 1 << (node.level - 1);
    for (const int y : {node.y, node.y + step}) {
      for (const int x : {node.x, node.x + step}) {
        const int hits = bound(t, x, y, node.level - 1);
        if (hits >= least && hits >= near_best * best) open.push({hits, node.heading, x, y, node.level - 1});
      }
    }
  }
  for (const Peak& peak : peaks) {
    const Pose2d turn{Eigen::Vector2d::Zero(), peak.yaw};
    PlaceHypothesis hypothesis = refined(query, {peak.center - turn.matrix() * center, peak.yaw});
    const bool known = std::any_of(result.hypotheses.begin(), result.hypotheses.end(), [&](const PlaceHypothesis& other) {
      return (other.T_map_query * center - hypothesis.T_map_query * center).norm() < 0.3 &&
             std::abs(wrapped(other.T_map_query.yaw - hypothesis.T_map_query.yaw)) < 0.5 * same_heading;
    });
    if (!known) result.hypotheses.push_back(hypothesis);
  }
  std::stable_sort(result.hypotheses.begin(), result.hypotheses.end(),
                   [](const PlaceHypothesis& a, const PlaceHypothesis& b) { return a.fit.cost() < b.fit.cost(); });
  return result;
}

PlaceHypothesis PlaceSearch::refined(const Layout& query, const Pose2d& guess) const {
  PlaceHypothesis hypothesis{guess, {}};
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  for (const WallSample& s : query.samples()) center += s.point / static_cast<double>(query.samples().size());
  for (const double reach : {0.4, 0.3, 0.2, 0.15, 0.1, 0.1}) {
    Pose2d& T = hypothesis.T_map_query;
    const Eigen::Matrix2d R = T.matrix();
    const Eigen::Vector2d middle = T * center;
    Eigen::Matrix3d A = Eigen::Vector3d(1e-3, 1e-3, 1e-3).asDiagonal();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (const WallSample& s : query.samples()) {
      const Eigen::Vector2d p = R * s.point + T.translation;
      const auto hit = index_.nearest(p, R * s.normal, reach, 0.97);
      if (!hit) continue;
      const Eigen::Vector2d arm = p - middle;
      const Eigen::Vector3d J(hit->normal.x(), hit->normal.y(), hit->normal.y() * arm.x() - hit->normal.x() * arm.y());
      const double scale = 0.3 * reach;
      const double weight = 1 / (1 + hit->distance * hit->distance / (scale * scale));
      A += weight * J * J.transpose();
      b -= weight * J * hit->distance;
    }
    const Eigen::Vector3d step = A.ldlt().solve(b);
    const Eigen::Vector2d moved = middle + step.head<2>();
    T.yaw = wrapped(T.yaw + step.z());
    T.translation = moved - T.matrix() * center;
  }
  hypothesis.fit = fit(query, hypothesis.T_map_query);
  return hypothesis;
}

LayoutFit PlaceSearch::fit(const Layout& query, const Pose2d& T_map_query) const {
  LayoutFit fit;
  const Eigen::Matrix2d R = T_map_query.matrix();
  const double length = WallSample::spacing;
  double squares = 0;
  std::vector<WallSample> against;
  double count = 0;
  for (const WallSample& s : query.samples()) {
    if (!s.solid) continue;
    fit.total += length;
    const Eigen::Vector2d p = R * s.point + T_map_query.translation;
    const auto hit = index_.nearest(p, R * s.normal, beside, parallel);
    if (hit && std::abs(hit->distance) <= matched_across) {
      fit.matched += length;
      squares += hit->distance * hit->distance;
      ++count;
    } else if (hit || map_.is_free(p)) {
      against.push_back(s);
    } else {
      fit.unknown += length;
    }
  }
  if (count > 0) fit.rms = std::sqrt(squares / count);
  // Walls of the map that the query looks through.
  const Pose2d T_query_map = T_map_query.inverse();
  const Eigen::Matrix2d back = T_query_map.matrix();
  const WallIndex seen(query);
  for (const WallSample& s : map_.samples()) {
    if (!s.solid) continue;
    const Eigen::Vector2d p = back * s.point + T_query_map.translation;
    if (query.is_free(p) && !seen.nearest(p, back * s.normal, 2 * matched_across, parallel)) against.push_back({p, back * s.normal, true});
  }
  fit.contradicted = length * static_cast<double>(against.size());
  fit.long_pieces = length_of_long_pieces(against);
  return fit;
}

}  // namespace sgraph
