#include "sgraph_slam/core/registration/ring_image.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace sgraph {
namespace {

constexpr float farthest = 8.0F;         // [m] between a point and the ring beside it
constexpr float beside = 0.25F;          // [m] between a point and those on its own ring that it is compared with
constexpr float thinning = 0.1F;         // [m] that points may be apart along a ring of a thinned scan
constexpr float off_ring = 0.08F;        // [m] of a point from the line through those: noise along the rays lies across it
constexpr float off_line = 0.04F;        // [m] of a point from the line through the rings beside it,
constexpr float off_line_share = 0.05F;  // and of their distance
constexpr float least_sine = 0.5F;       // of the angle between the directions along and across the ring

int column_of(const Eigen::Vector3f& p, int columns) {
  const auto turn = static_cast<float>(2 * M_PI);
  const float share = std::atan2(p.y(), p.x()) / turn;
  return std::clamp(static_cast<int>((share < 0 ? share + 1 : share) * static_cast<float>(columns)), 0, columns - 1);
}

float distance_from_line(const Eigen::Vector3f& p, const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  const Eigen::Vector3f line = b - a;
  return (p - a).cross(line).norm() / line.norm();
}

}  // namespace

RingImage::RingImage(const Cloud& scan) {
  std::vector<double> elevation(most_rings, 0);
  std::vector<int> count(most_rings, 0);
  for (const Point& p : scan.points) {
    if (p.ring >= most_rings) return;
    elevation[p.ring] += static_cast<double>(p.z) / std::max(1e-6F, std::hypot(p.x, p.y));
    ++count[p.ring];
  }
  std::vector<int> rings;
  for (int ring = 0; ring < most_rings; ++ring) {
    if (count[static_cast<std::size_t>(ring)] > 0) rings.push_back(ring);
  }
  if (rings.size() < 3) return;
  std::sort(rings.begin(), rings.end(), [&](int a, int b) {
    const auto i = static_cast<std::size_t>(a), j = static_cast<std::size_t>(b);
    return elevation[i] / count[i] < elevation[j] / count[j];
  });
  rows_ = static_cast<int>(rings.size());
  row_of_ring_.assign(most_rings, -1);
  for (int row = 0; row < rows_; ++row) row_of_ring_[static_cast<std::size_t>(rings[static_cast<std::size_t>(row)])] = row;
  cells_.assign(static_cast<std::size_t>(rows_) * columns, Eigen::Vector3f::Zero());
  for (const Point& p : scan.points) {
    const Eigen::Vector3f position = p.position();
    const int row = row_of_ring_[p.ring];
    cells_[static_cast<std::size_t>(row) * columns + static_cast<std::size_t>(column_of(position, columns))] = position;
  }
}

const Eigen::Vector3f* RingImage::at(int row, int column) const {
  if (row < 0 || row >= rows_) return nullptr;
  const Eigen::Vector3f& cell = cells_[static_cast<std::size_t>(row) * columns + static_cast<std::size_t>((column + 2 * columns) % columns)];
  return cell.isZero() ? nullptr : &cell;
}

// The first cell that isn't empty, from the column outwards.
const Eigen::Vector3f* RingImage::nearest(int row, int column, int reach) const {
  for (int k = 0; k <= reach; ++k) {
    if (const Eigen::Vector3f* p = at(row, column + k)) return p;
    if (const Eigen::Vector3f* p = at(row, column - k)) return p;
  }
  return nullptr;
}

std::optional<Eigen::Vector3f> RingImage::normal(const Point& point) const {
  if (rows_ < 3 || point.ring >= most_rings) return std::nullopt;
  const Eigen::Vector3f p = point.position();
  const int row = row_of_ring_[point.ring];
  const int column = column_of(p, columns);
  const float cell = static_cast<float>(2 * M_PI / columns) * std::max(0.1F, std::hypot(p.x(), p.y()));
  const int reach = 1 + static_cast<int>(thinning / cell);
  const Eigen::Vector3f* below = nearest(row - 1, column, reach);
  const Eigen::Vector3f* above = nearest(row + 1, column, reach);
  if (below == nullptr || above == nullptr) return std::nullopt;
  const float down = (*below - p).norm();
  const float up = (*above - p).norm();
  if (std::min(down, up) < least_spacing || std::max(down, up) > farthest) return std::nullopt;
  if (distance_from_line(p, *below, *above) > std::min(off_line, off_line_share * (*above - *below).norm())) return std::nullopt;
  const int step = reach + static_cast<int>(beside / cell);
  const Eigen::Vector3f* left = nearest(row, column + step, reach);
  const Eigen::Vector3f* right = nearest(row, column - step, reach);
  if (left == nullptr || right == nullptr || distance_from_line(p, *left, *right) > off_ring) return std::nullopt;
  const Eigen::Vector3f across = (*above - *below).normalized();
  const Eigen::Vector3f along = (*left - *right).normalized();
  const Eigen::Vector3f cross = across.cross(along);
  if (cross.norm() < least_sine) return std::nullopt;
  const Eigen::Vector3f normal = cross.normalized();
  return normal.dot(p) > 0 ? Eigen::Vector3f(-normal) : normal;
}

}  // namespace sgraph
