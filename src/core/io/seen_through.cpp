#include "sgraph_slam/core/io/seen_through.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ray_origins.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

constexpr double finest_cell = 0.2;           // [m]
constexpr double most_cells = 20e6;           // 200 MB while it is made
constexpr double reach = 6;                   // of the judgement about a sensor: farther off rays are too far apart to hit what is thin [m]
constexpr double clearance = 0.4;             // a ray says nothing of what lies this near to its end [m]
constexpr std::uint8_t rays_for_a_look = 6;   // through one cell, by one keyframe
constexpr std::uint8_t looks_for_a_pass = 2;  // keyframes; one may have looked past an edge
constexpr double on_plane = 0.08;             // [m]: a wall's noise, and what a plane's estimate may be off
constexpr double beside_plane = 0.2;          // [m] beyond its outline

// Visits the cells that a straight way passes, in order, in cells from the grid's corner, while `visit` says so.
template <class Visit>
void walk(const Eigen::Vector3d& from, const Eigen::Vector3d& to, Visit visit) {
  const Eigen::Vector3d way = to - from;
  Eigen::Vector3i cell = from.array().floor().cast<int>();
  const Eigen::Vector3i end = to.array().floor().cast<int>();
  Eigen::Vector3i step;
  Eigen::Vector3d next;   // where along the way the next cell of each axis begins
  Eigen::Vector3d delta;  // from one to the next
  for (int k = 0; k < 3; ++k) {
    const bool still = std::abs(way[k]) < 1e-9;
    step[k] = way[k] < 0 ? -1 : 1;
    delta[k] = still ? std::numeric_limits<double>::infinity() : 1 / std::abs(way[k]);
    next[k] = still ? delta[k] : (way[k] < 0 ? from[k] - cell[k] : cell[k] + 1 - from[k]) * delta[k];
  }
  while (visit(cell) && cell != end) {
    int k = next.x() < next.y() ? 0 : 1;
    if (next.z() < next[k]) k = 2;
    if (next[k] > 1) return;
    cell[k] += step[k];
    next[k] += delta[k];
  }
}

bool is_within(const std::vector<Eigen::Vector3d>& outline, const Eigen::Vector3d& normal, const Eigen::Vector3d& p, double margin) {
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector3d edge = outline[(i + 1) % outline.size()] - outline[i];
    if (normal.dot(edge.cross(p - outline[i])) < -margin * edge.norm()) return false;
  }
  return outline.size() >= 3;
}

}  // namespace

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
  passes_.assign(count, 0);
  std::vector<std::int32_t> near_hit(count, -1);  // newest keyframe that hit the cell or one beside it
  std::vector<std::int32_t> looked(count, -1);    // newest keyframe with a ray through it
  std::vector<std::uint8_t> rays(count, 0);       // of that one

  const std::vector<std::uint8_t> of_plane = plane_cells();

  std::int32_t now = -1;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    const CloudPtr cloud = keyframe.cloud.get();
    ++now;
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
      passes_[index(cell)] = 0;
      if (looked[index(cell)] == now) continue;  // by another point
      looked[index(cell)] = now;
      near_hit[index(cell)] = now;
      if (of_plane[index(cell)] != 0) continue;  // what hits a wall says nothing of who stands before it
      for (int z = -1; z <= 1; ++z) {
        for (int y = -1; y <= 1; ++y) {
          for (int x = -1; x <= 1; ++x) {
            const Eigen::Vector3i beside = cell + Eigen::Vector3i(x, y, z);
            if (holds(beside)) near_hit[index(beside)] = now;
          }
        }
      }
    }
    for (const Point& point : cloud->points) {
      if (!point.position().allFinite()) continue;
      const Eigen::Vector3d& eye = origins.of(point);
      const Eigen::Vector3d ray = in_map(point) - eye;
      const double length = std::min(ray.norm() - clearance, reach);
      if (!(length > 0)) continue;
      const Eigen::Vector3d from = (eye - origin_) / cell_;
      walk(from, from + ray.normalized() * (length / cell_), [&](const Eigen::Vector3i& cell) {
        if (!holds(cell)) return false;
        const std::size_t i = index(cell);
        if (near_hit[i] == now) return true;
        if (looked[i] != now) {
          looked[i] = now;
          rays[i] = 0;
        }
        if (rays[i] < rays_for_a_look && ++rays[i] == rays_for_a_look && passes_[i] < looks_for_a_pass) ++passes_[i];
        return true;
      });
    }
  }
}

std::vector<std::uint8_t> SeenThrough::plane_cells() const {
  std::vector<std::uint8_t> cells(passes_.size(), 0);
  for (const Surface& surface : surfaces_) {
    const Eigen::Matrix<double, 3, 2> basis = tangent_basis(surface.plane.normal);
    Eigen::AlignedBox2d area;
    for (const Eigen::Vector3d& corner : surface.outline) area.extend(Eigen::Vector2d(basis.transpose() * corner));
    const double step = 0.5 * cell_;
    for (double u = area.min().x(); u <= area.max().x() + step; u += step) {
      for (double v = area.min().y(); v <= area.max().y() + step; v += step) {
        const Eigen::Vector3d p = basis * Eigen::Vector2d(u, v) - surface.plane.d * surface.plane.normal;
        const Eigen::Vector3d at = (p - origin_) / cell_;
        if (!((at.array() >= 0).all() && (at.array() < size_.cast<double>().array()).all())) continue;
        if (is_within(surface.outline, surface.plane.normal, p, beside_plane)) cells[index(cell_of(p))] = 1;
      }
    }
  }
  return cells;
}

bool SeenThrough::operator()(const Eigen::Vector3d& p_map) const {
  const Eigen::Vector3d at = (p_map - origin_) / cell_;
  if (passes_.empty() || !((at.array() >= 0).all() && (at.array() < size_.cast<double>().array()).all())) return false;  // false for NaN
  return passes_[index(cell_of(p_map))] >= looks_for_a_pass && !is_on_a_plane(p_map);
}

bool SeenThrough::is_on_a_plane(const Eigen::Vector3d& p_map) const {
  return std::any_of(surfaces_.begin(), surfaces_.end(), [&](const Surface& surface) {
    return surface.box.contains(p_map) && std::abs(surface.plane.distance(p_map)) < on_plane &&
           is_within(surface.outline, surface.plane.normal, p_map, beside_plane);
  });
}

}  // namespace sgraph
