#include "ray_passes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sgraph_slam/core/math/walk_cells.hpp"

namespace sgraph::mirrors {
namespace {

constexpr double pass_cell = 0.2;  // of the raster in which rays count that go on [m]
constexpr double goes_on = 0.3;    // deeper behind the wall than what they passed, such rays end [m]
constexpr double clearance = 0.4;  // and so much farther along [m]
constexpr double most_pass_cells = 20e6;
constexpr std::uint8_t least_passes = 6;  // rays; a few may slip past an edge

}  // namespace

RayPasses::RayPasses(const Eigen::AlignedBox3d& bounds) {
  if (bounds.isEmpty()) return;  // nothing is counted
  cell_ = std::max(pass_cell, std::cbrt(bounds.volume() / most_pass_cells));
  origin_ = bounds.min().array() - border * cell_;
  size_ = (bounds.sizes() / cell_).array().ceil().cast<int>() + 2 * border;
  count_.assign(static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()) * static_cast<std::size_t>(size_.z()), 0);
}

void RayPasses::add(const Sight& sight, const Wall& wall) {
  if (count_.empty()) return;
  const double before = wall.plane.distance(sight.eye);
  const double whole = before - wall.plane.distance(sight.p);
  double begin = before / whole;
  double end = std::min(1 - goes_on / whole, 1 - clearance / (sight.p - sight.eye).norm());
  const Eigen::Vector3d from = (sight.eye - origin_) / cell_;
  const Eigen::Vector3d way = (sight.p - sight.eye) / cell_;
  // Cut off within the border: a way that ends on the raster's edge could go on in its next row.
  constexpr double edge = 0.5 * border;
  for (int k = 0; k < 3; ++k) {
    if (std::abs(way[k]) < 1e-9) {
      if (!(from[k] >= edge && from[k] <= size_[k] - edge)) return;
      continue;
    }
    const double low = (edge - from[k]) / way[k];
    const double high = (size_[k] - edge - from[k]) / way[k];
    begin = std::max(begin, std::min(low, high));
    end = std::min(end, std::max(low, high));
  }
  if (!(begin < end)) return;
  const std::array<std::ptrdiff_t, 3> rows{1, size_.x(), static_cast<std::ptrdiff_t>(size_.x()) * size_.y()};
  walk_cells<3>(from + begin * way, from + end * way, rows, [&](std::ptrdiff_t i, std::int64_t, std::int64_t) {
    if (i < 0 || static_cast<std::size_t>(i) >= count_.size()) return true;
    std::uint8_t& count = count_[static_cast<std::size_t>(i)];
    if (count < least_passes) ++count;
    return true;
  });
}

bool RayPasses::enough_at(const Eigen::Vector3d& p) const {
  const Eigen::Array3d at = (p - origin_).array() / cell_;
  if (count_.empty() || !((at >= 0).all() && (at < size_.cast<double>().array()).all())) return false;
  const Eigen::Array<std::ptrdiff_t, 3, 1> c = at.floor().cast<std::ptrdiff_t>();
  return count_[static_cast<std::size_t>(c.x() + size_.x() * (c.y() + size_.y() * c.z()))] >= least_passes;
}

}  // namespace sgraph::mirrors
