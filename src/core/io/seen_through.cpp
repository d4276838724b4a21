#include "sgraph_slam/core/io/seen_through.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "ray_origins.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/math/walk_cells.hpp"

namespace sgraph {
namespace {

constexpr double finest_cell = 0.2;           // [m]
constexpr double most_cells = 20e6;           // 120 MB while it is made
constexpr double reach = 6;                   // of the judgement about a sensor: farther off rays are too far apart to hit what is thin [m]
constexpr double clearance = 0.4;             // a ray says nothing of what lies this near to its end [m]
constexpr std::int32_t rays_for_a_look = 6;   // through one cell, by one keyframe
constexpr std::uint8_t looks_for_a_pass = 2;  // keyframes; one may have looked past an edge
// Keyframes that hit who only walks by, for each time that somebody has come after the place was empty: half a metre wide at half a metre a second
// one is out of a cell after a second and a half, and a keyframe lasts longer than that. Where people come and go they also meet, and wait.
constexpr int hits_a_coming = 2;
constexpr std::uint8_t most_comings = 3;
constexpr std::uint8_t most_hits = 7;  // more aren't counted
constexpr double on_plane = 0.08;      // [m]: a wall's noise, and what a plane's estimate may be off
constexpr double beside_plane = 0.2;   // [m] beyond its outline
constexpr double empty_share = 0.8;    // of the cells of a plane that people made

// What a keyframe says of a cell, with its number in one word: words of earlier keyframes are smaller, so nothing is ever cleared.
constexpr std::int32_t words = 16;       // a keyframe
constexpr std::int32_t near_a_hit = 14;  // below that: rays through it
constexpr std::int32_t is_hit = 15;

bool is_within(const std::vector<Eigen::Vector3d>& outline, const Eigen::Vector3d& normal, const Eigen::Vector3d& p, double margin) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector3d edge = outline[(i + 1) % outline.size()] - outline[i];
    if (normal.dot(edge.cross(p - outline[i])) < -margin * edge.norm()) return false;
  }
  return outline.size() >= 3;
}

}  // namespace

void SeenThrough::Cell::hit() {
  if (passes >= looks_for_a_pass) {
    if (comings < most_comings) ++comings;
    hits = 0;
  }
  if (hits < most_hits) ++hits;
  passes = 0;
}

void SeenThrough::Cell::look_through() {
  if (passes < looks_for_a_pass) ++passes;
}

bool SeenThrough::Cell::is_empty() const { return passes >= looks_for_a_pass || (comings > 0 && hits <= hits_a_coming * comings); }

SeenThrough::SeenThrough(const GraphSnapshot& snapshot, const Pose& T_base_lidar) {
  for (const auto& [id, plane] : snapshot.planes) {
    Surface surface{plane.plane, plane.extent, {}};
    for (const Eigen::Vector3d& corner : plane.extent) surface.box.extend(corner);
    if (surface.box.isEmpty()) continue;
    surface.box.min().array() -= beside_plane;
    surface.box.max().array() += beside_plane;
    surfaces_.push_back(std::move(surface));
  }
  Eigen::AlignedBox3d bounds;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    const Eigen::Vector3d at = (keyframe.T_map_base * T_base_lidar).translation;
    if (keyframe.cloud && at.allFinite()) bounds.extend(at);
  }
  if (bounds.isEmpty()) return;
  bounds.min().array() -= reach + 1;
  bounds.max().array() += reach + 1;
  Eigen::AlignedBox1d heights;  // of the building
  for (const Surface& surface : surfaces_) heights.extend(surface.box.min().tail<1>()).extend(surface.box.max().tail<1>());
  if (!heights.isEmpty()) {
    bounds.min().z() = std::max(bounds.min().z(), std::min(heights.min().x(), bounds.min().z() + reach));
    bounds.max().z() = std::min(bounds.max().z(), std::max(heights.max().x(), bounds.max().z() - reach));
  }
  cell_ = std::max(finest_cell, std::cbrt(bounds.volume() / most_cells));
  origin_ = bounds.min();
  size_ = (bounds.sizes() / cell_).array().ceil().cast<int>().max(1);
  const std::size_t count = index({0, 0, size_.z()});
  cells_.assign(count, {});
  // With a layer below and one above: a ray that ends at the border may step over it.
  const std::size_t layer = index({0, 0, 1});
  std::vector<std::int32_t> padded(count + 2 * layer, -1);
  std::int32_t* const word = padded.data() + layer;
  const std::array<std::ptrdiff_t, 3> rows{1, size_.x(), static_cast<std::ptrdiff_t>(layer)};
  const std::vector<std::uint8_t> of_plane = plane_cells();

  std::int32_t now = -words;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    const CloudPtr cloud = keyframe.cloud.get();
    now += words;
    if (!cloud) continue;
    const Pose T_map_lidar = keyframe.T_map_base * T_base_lidar;
    const RayOrigins origins(*cloud, T_map_lidar);
    const Eigen::Matrix3d rotation = T_map_lidar.matrix();
    const auto in_map = [&](const Point& p) -> Eigen::Vector3d { return rotation * p.position().cast<double>() + T_map_lidar.translation; };
    for (const Point& point : cloud->points) {
      if (!point.position().allFinite()) continue;
      const Eigen::Vector3d p = in_map(point);
      if (!((p - origin_).cwiseAbs().maxCoeff() < 1e6)) continue;
      const Eigen::Vector3i cell = cell_of(p);
      if (!holds(cell)) continue;
      std::int32_t& own = word[index(cell)];
      if (own == now + is_hit) continue;  // by another point
      own = now + is_hit;
      cells_[index(cell)].hit();
      if (of_plane[index(cell)] != 0) continue;  // what hits a wall says nothing of who stands before it
      for (int z = -1; z <= 1; ++z) {
        for (int y = -1; y <= 1; ++y) {
          for (int x = -1; x <= 1; ++x) {
            const Eigen::Vector3i beside = cell + Eigen::Vector3i(x, y, z);
            if (holds(beside)) word[index(beside)] = std::max(word[index(beside)], now + near_a_hit);
          }
        }
      }
    }
    for (const Point& point : cloud->points) {
      if (!point.position().allFinite()) continue;
      const Eigen::Vector3d& eye = origins.of(point);
      const Eigen::Vector3d ray = in_map(point) - eye;
      const double whole = ray.norm();
      double length = std::min(whole - clearance, reach);
      if (!(length > 0)) continue;
      const Eigen::Vector3d from = (eye - origin_) / cell_;
      if (!holds(from.array().floor().cast<int>())) continue;
      const Eigen::Vector3d way = ray / (whole * cell_);
      // Only heights were cut off from what the rays can reach.
      if (way.z() > 0) length = std::min(length, (size_.z() - from.z()) / way.z());
      if (way.z() < 0) length = std::min(length, -from.z() / way.z());
      const Eigen::Vector3d to = from + length * way;
      if (!((to.head<2>().array() >= 0).all() && (to.head<2>().array() < size_.head<2>().cast<double>().array()).all())) continue;
      walk_cells<3>(from, to, rows, [&](std::ptrdiff_t i, std::int64_t, std::int64_t) {
        const std::int32_t rays = std::max(word[i] - now, 0);
        if (rays >= rays_for_a_look) return true;  // enough, or beside a hit
        word[i] = now + rays + 1;
        if (rays + 1 < rays_for_a_look || i < 0 || static_cast<std::size_t>(i) >= count) return true;
        cells_[static_cast<std::size_t>(i)].look_through();
        return true;
      });
    }
  }
  surfaces_.erase(std::remove_if(surfaces_.begin(), surfaces_.end(), [&](const Surface& surface) { return is_of_passers(surface); }),
                  surfaces_.end());
}

template <class Visit>
void SeenThrough::visit_cells(const Surface& surface, Visit&& visit) const {
  const Eigen::Matrix<double, 3, 2> basis = tangent_basis(surface.plane.normal);
  Eigen::AlignedBox2d area;
  for (const Eigen::Vector3d& corner : surface.outline) area.extend(Eigen::Vector2d(basis.transpose() * corner));
  const double step = 0.5 * cell_;
  for (double u = area.min().x(); u <= area.max().x() + step; u += step) {
    for (double v = area.min().y(); v <= area.max().y() + step; v += step) {
      const Eigen::Vector3d p = basis * Eigen::Vector2d(u, v) - surface.plane.d * surface.plane.normal;
      const Eigen::Vector3d at = (p - origin_) / cell_;
      if (!((at.array() >= 0).all() && (at.array() < size_.cast<double>().array()).all())) continue;
      if (is_within(surface.outline, surface.plane.normal, p, beside_plane)) visit(index(cell_of(p)));
    }
  }
}

std::vector<std::uint8_t> SeenThrough::plane_cells() const {
  std::vector<std::uint8_t> cells(cells_.size(), 0);
  for (const Surface& surface : surfaces_) visit_cells(surface, [&](std::size_t i) { cells[i] = 1; });
  return cells;
}

bool SeenThrough::is_of_passers(const Surface& surface) const {
  int hit = 0;
  int empty = 0;
  visit_cells(surface, [&](std::size_t i) {
    if (cells_[i].hits == 0) return;
    ++hit;
    empty += cells_[i].is_empty();
  });
  return empty > empty_share * hit;
}

bool SeenThrough::operator()(const Eigen::Vector3d& p_map) const {
  const Eigen::Vector3d at = (p_map - origin_) / cell_;
  if (cells_.empty() || !((at.array() >= 0).all() && (at.array() < size_.cast<double>().array()).all())) return false;  // false for NaN
  return cells_[index(cell_of(p_map))].is_empty() && !is_on_a_plane(p_map);
}

bool SeenThrough::is_on_a_plane(const Eigen::Vector3d& p_map) const {
  return std::any_of(surfaces_.begin(), surfaces_.end(), [&](const Surface& surface) {
    return surface.box.contains(p_map) && std::abs(surface.plane.distance(p_map)) < on_plane &&
           is_within(surface.outline, surface.plane.normal, p_map, beside_plane);
  });
}

}  // namespace sgraph
