#include "sgraph_slam/core/search/layout.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

namespace sgraph {
namespace {

constexpr int directions = 16;             // of faces that count as one
constexpr double longest = 1e4;            // [m] of a piece; more is no building
constexpr double joined = 0.35;            // [m] between two samples of one piece
constexpr double joined_parallel = 0.985;  // cosine of 10 degrees
constexpr std::int64_t most_cells = 400'000'000;

int direction_of(const Eigen::Vector2d& normal) {
  const double turns = std::atan2(normal.y(), normal.x()) / (2 * M_PI);
  return static_cast<int>(std::floor((turns - std::floor(turns)) * directions)) % directions;
}

std::vector<WallSample> samples_of(const std::vector<WallPiece>& pieces) {
  std::map<std::tuple<int, int, int>, WallSample> samples;
  for (const WallPiece& piece : pieces) {
    const double length = (piece.to - piece.from).norm();
    if (!(length < longest)) continue;
    const int count = std::max(1, static_cast<int>(std::lround(2 * length / WallSample::spacing)));
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d p = piece.from + (i + 0.5) / count * (piece.to - piece.from);
      const Eigen::Vector2d cell = (p / WallSample::spacing).array().floor();
      samples.try_emplace({static_cast<int>(cell.x()), static_cast<int>(cell.y()), direction_of(piece.normal)}, WallSample{p, piece.normal, true});
    }
  }
  std::vector<WallSample> result;
  for (const auto& [key, sample] : samples) result.push_back(sample);
  return result;
}

}  // namespace

SeenFree::SeenFree(const std::vector<Sight>& sights) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d high = -low;
  for (const Sight& sight : sights) {
    for (const auto& p : {sight.sensor, sight.from, sight.to}) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  if (sights.empty()) return;
  const Eigen::Vector2d size = ((high - low) / cell).array().ceil() + 1;
  if (!(size.x() * size.y() < static_cast<double>(most_cells))) return;
  origin_ = low;
  width_ = static_cast<int>(size.x());
  height_ = static_cast<int>(size.y());
  votes_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
  for (const Sight& sight : sights) add(sight);
}

void SeenFree::add(const Sight& sight) {
  // The far side is drawn in by the margin, along the rays.
  const auto drawn_in = [&sight](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    const double distance = (p - sight.sensor).norm();
    return distance > margin ? Eigen::Vector2d(sight.sensor + (1 - margin / distance) * (p - sight.sensor)) : sight.sensor;
  };
  const std::array<Eigen::Vector2d, 3> corners{sight.sensor, drawn_in(sight.from), drawn_in(sight.to)};
  double low = corners[0].y();
  double high = low;
  for (const auto& c : corners) {
    low = std::min(low, c.y());
    high = std::max(high, c.y());
  }
  const int first = std::max(0, static_cast<int>(std::ceil((low - origin_.y()) / cell - 0.5)));
  const int last = std::min(height_ - 1, static_cast<int>(std::floor((high - origin_.y()) / cell - 0.5)));
  for (int row = first; row <= last; ++row) {
    const double y = origin_.y() + (row + 0.5) * cell;
    double left = 1e9;
    double right = -1e9;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& a = corners[i];
      const auto& b = corners[(i + 1) % 3];
      if ((a.y() <= y) == (b.y() <= y)) continue;
      const double x = a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
      left = std::min(left, x);
      right = std::max(right, x);
    }
    const int begin = std::max(0, static_cast<int>(std::ceil((left - origin_.x()) / cell - 0.5)));
    const int end = std::min(width_ - 1, static_cast<int>(std::floor((right - origin_.x()) / cell - 0.5)));
    for (int column = begin; column <= end; ++column) {
      auto& votes = votes_[static_cast<std::size_t>(row) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(column)];
      if (votes < 255) ++votes;
    }
  }
}

bool SeenFree::contains(const Eigen::Vector2d& point, int votes) const {
  const Eigen::Vector2d at = ((point - origin_) / cell).array().floor();
  if (!(at.x() >= 0 && at.y() >= 0 && at.x() < width_ && at.y() < height_)) return false;
  return votes_[static_cast<std::size_t>(at.y()) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(at.x())] >= votes;
}

Layout::Layout(std::vector<WallPiece> pieces, const std::vector<Sight>& sights, int votes)
    : pieces_(std::move(pieces)), free_(sights), votes_(votes), samples_(samples_of(pieces_)) {
  for (WallSample& sample : samples_) sample.solid = !is_free(sample.point);
}

std::vector<std::vector<std::size_t>> joined_pieces(const std::vector<WallSample>& samples) {
  std::vector<std::vector<std::size_t>> pieces;
  std::vector<bool> taken(samples.size(), false);
  for (std::size_t first = 0; first < samples.size(); ++first) {
    if (taken[first]) continue;
    taken[first] = true;
    std::vector<std::size_t> piece{first};
    for (std::size_t next = 0; next < piece.size(); ++next) {
      const WallSample& at = samples[piece[next]];
      for (std::size_t i = 0; i < samples.size(); ++i) {
        if (taken[i] || (samples[i].point - at.point).squaredNorm() > joined * joined || samples[i].normal.dot(at.normal) < joined_parallel) continue;
        taken[i] = true;
        piece.push_back(i);
      }
    }
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

Eigen::Matrix2d Pose2d::matrix() const {
  Eigen::Matrix2d R;
  R << std::cos(yaw), -std::sin(yaw), std::sin(yaw), std::cos(yaw);
  return R;
}

Pose2d Pose2d::inverse() const { return {-(matrix().transpose() * translation), -yaw}; }

WallIndex::WallIndex(const Layout& layout) : layout_(layout) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9);
  Eigen::Vector2d high = -low;
  for (const WallPiece& piece : layout.pieces()) {
    low = low.cwiseMin(piece.from.cwiseMin(piece.to));
    high = high.cwiseMax(piece.from.cwiseMax(piece.to));
  }
  if (layout.pieces().empty()) return;
  origin_ = low - Eigen::Vector2d::Constant(2 * cell_);
  const Eigen::Vector2d size = ((high - origin_) / cell_).array().ceil() + 3;
  if (!(size.x() * size.y() < 1e8)) return;
  width_ = static_cast<int>(size.x());
  height_ = static_cast<int>(size.y());
  pieces_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (std::size_t i = 0; i < layout.pieces().size(); ++i) {
    const WallPiece& piece = layout.pieces()[i];
    const double length = (piece.to - piece.from).norm();
    const int steps = 1 + static_cast<int>(std::ceil(2 * length / cell_));
    for (int s = 0; s <= steps; ++s) {
      const Eigen::Vector2d p = piece.from + static_cast<double>(s) / steps * (piece.to - piece.from);
      const Eigen::Vector2i at = ((p - origin_) / cell_).array().floor().cast<int>();
      for (int y = at.y() - 1; y <= at.y() + 1; ++y) {
        for (int x = at.x() - 1; x <= at.x() + 1; ++x) {
          auto& list = pieces_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
          if (list.empty() || list.back() != i) list.push_back(static_cast<std::uint32_t>(i));
        }
      }
    }
  }
}

std::optional<WallIndex::Hit> WallIndex::nearest(const Eigen::Vector2d& point, const Eigen::Vector2d& normal, double reach, double cosine) const {
  const Eigen::Vector2d at = ((point - origin_) / cell_).array().floor();
  if (!(at.x() >= 0 && at.y() >= 0 && at.x() < width_ && at.y() < height_)) return std::nullopt;
  std::optional<Hit> best;
  for (const std::uint32_t i : pieces_[static_cast<std::size_t>(at.y()) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(at.x())]) {
    const WallPiece& piece = layout_.pieces()[i];
    if (piece.normal.dot(normal) < cosine) continue;
    const double across = piece.normal.dot(point - piece.from);
    if (std::abs(across) > reach || (best && std::abs(across) >= std::abs(best->distance))) continue;
    const Eigen::Vector2d way = piece.to - piece.from;
    const double length = way.norm();
    const double along = length > 0 ? way.dot(point - piece.from) / length : 0;
    if (along < -reach || along > length + reach) continue;
    best = Hit{piece.normal, across};
  }
  return best;
}

}  // namespace sgraph
