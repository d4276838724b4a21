#include "mirror_walls.hpp"

#include "sgraph_slam/core/io/map_cloud.hpp"

namespace sgraph::mirrors {
namespace {

constexpr double least_length = 1.0;   // of a wall, each way: anything smaller is furniture [m]
constexpr int most_cells = 4'000'000;  // of one wall's raster

}  // namespace

std::optional<Wall> wall_of(const ScenePlane& plane) {
  if (std::abs(plane.plane.normal.z()) > 0.2 || plane.extent.size() < 3) return std::nullopt;
  Wall wall;
  wall.plane = plane.plane;
  wall.along = Eigen::Vector3d::UnitZ().cross(plane.plane.normal).normalized();
  wall.up = plane.plane.normal.cross(wall.along);
  Eigen::AlignedBox2d box;
  std::vector<Eigen::Vector2d> outline;
  for (const Eigen::Vector3d& p : plane.extent) {
    outline.emplace_back(wall.along.dot(p), wall.up.dot(p));
    wall.box.extend(p);
    box.extend(outline.back());
  }
  if (!(box.sizes().minCoeff() >= least_length) || box.volume() / (cell * cell) > most_cells) return std::nullopt;
  wall.corner = box.min();
  wall.columns = static_cast<int>(box.sizes().x() / cell) + 1;
  wall.rows = static_cast<int>(box.sizes().y() / cell) + 1;
  const std::size_t count = static_cast<std::size_t>(wall.columns) * static_cast<std::size_t>(wall.rows);
  wall.inside.assign(count, 0);
  wall.passes.assign(count, 0);
  wall.returns.assign(count, 0);
  wall.hole.assign(count, -1);
  double turn = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& a = outline[i];
    const Eigen::Vector2d& b = outline[(i + 1) % outline.size()];
    turn += a.x() * b.y() - a.y() * b.x();
  }
  for (int row = 0; row < wall.rows; ++row) {
    for (int column = 0; column < wall.columns; ++column) {
      const Eigen::Vector2d at = wall.corner + cell * Eigen::Vector2d(column + 0.5, row + 0.5);
      bool in = true;
      for (std::size_t i = 0; i < outline.size() && in; ++i) {
        const Eigen::Vector2d edge = outline[(i + 1) % outline.size()] - outline[i];
        const Eigen::Vector2d to = at - outline[i];
        in = (edge.x() * to.y() - edge.y() * to.x()) * turn >= 0;
      }
      wall.inside[static_cast<std::size_t>(row) * static_cast<std::size_t>(wall.columns) + static_cast<std::size_t>(column)] = in ? 1 : 0;
    }
  }
  return wall;
}

void find_floors(const GraphSnapshot& snapshot, const Pose& T_base_lidar, std::vector<Wall>& walls) {
  constexpr double near = 5;  // [m]
  std::vector<double> nearest(walls.size(), std::numeric_limits<double>::infinity());
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    const Eigen::Vector3d at = (keyframe.T_map_base * T_base_lidar).translation;
    const auto floor = floor_below(snapshot, keyframe, T_base_lidar);
    if (!floor) continue;
    const double z = at.z() - floor->distance(at);
    for (std::size_t w = 0; w < walls.size(); ++w) {
      Wall& wall = walls[w];
      if (wall.plane.distance(at) <= 0) continue;
      const double distance = wall.box.exteriorDistance(at);
      if (distance < near) {
        wall.floor = nearest[w] < near ? std::min(wall.floor, z) : z;
        nearest[w] = std::min(nearest[w], distance);
      } else if (distance < nearest[w]) {
        wall.floor = z;
        nearest[w] = distance;
      }
    }
  }
}

}  // namespace sgraph::mirrors
