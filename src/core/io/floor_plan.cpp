#include "sgraph_slam/core/io/floor_plan.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "sgraph_slam/core/math/signed_area.hpp"

namespace sgraph {
namespace {

constexpr double wall_height = 1.0;   // lower than this is furniture [m]
constexpr double sample_step = 0.05;  // along walls [m]
constexpr double hidden_gap = 0.35;   // shorter gaps are no doors [m]
constexpr double shortest_run = 0.15;

bool obstacle_beside(const OccupancyGrid& grid, const Eigen::Vector2d& p, const Eigen::Vector2d& normal) {
  for (int k = -2; k <= 2; ++k) {
    if (grid.at(p + 0.05 * k * normal) == OccupancyGrid::occupied) return true;
  }
  return false;
}

// The parts of a wall where the grid has obstacles.
std::vector<Segment2d> solid_parts(const Segment2d& line, const OccupancyGrid& grid) {
  const double length = (line.second - line.first).norm();
  const Eigen::Vector2d along = (line.second - line.first) / length;
  const Eigen::Vector2d normal(-along.y(), along.x());
  std::vector<std::pair<double, double>> runs;
  const int samples = static_cast<int>(length / sample_step) + 1;
  for (int i = 0; i < samples; ++i) {
    const double s = std::min(length, (i + 0.5) * sample_step);
    if (!obstacle_beside(grid, line.first + s * along, normal)) continue;
    const double low = std::max(0.0, s - 0.5 * sample_step);
    const double high = std::min(length, s + 0.5 * sample_step);
    if (!runs.empty() && low - runs.back().second < hidden_gap) {
      runs.back().second = high;
    } else {
      runs.emplace_back(low, high);
    }
  }
  std::vector<Segment2d> parts;
  for (const auto& [low, high] : runs) {
    if (high - low >= shortest_run) parts.emplace_back(line.first + low * along, line.first + high * along);
  }
  return parts;
}

std::vector<DrawnWall> walls_of(const GraphSnapshot& snapshot, const OccupancyGrid& grid, bool obstacles_known) {
  std::vector<DrawnWall> walls;
  for (const auto& [id, plane] : snapshot.planes) {
    if (std::abs(plane.plane.normal.z()) > 0.3 || plane.extent.empty()) continue;
    const Eigen::Vector2d normal = plane.plane.normal.head<2>().normalized();
    const Eigen::Vector2d along(-normal.y(), normal.x());
    Eigen::AlignedBox1d span;
    Eigen::AlignedBox1d height;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const Eigen::Vector3d& corner : plane.extent) {
      span.extend(Eigen::Matrix<double, 1, 1>(along.dot(corner.head<2>())));
      height.extend(Eigen::Matrix<double, 1, 1>(corner.z()));
      middle += corner.head<2>() / static_cast<double>(plane.extent.size());
    }
    const Eigen::Vector2d foot = normal * normal.dot(middle);
    DrawnWall wall;
    wall.line = {foot + along * span.min()[0], foot + along * span.max()[0]};
    wall.low = height.sizes()[0] < wall_height;
    if (span.sizes()[0] < sample_step) continue;
    wall.solid = obstacles_known ? solid_parts(wall.line, grid) : std::vector<Segment2d>{wall.line};
    walls.push_back(std::move(wall));
  }
  return walls;
}

DrawnPlace place(const std::string& name, const Eigen::Vector3d& center, const Eigen::Vector2d& size, double yaw,
                 const std::vector<Eigen::Vector2d>& polygon) {
  DrawnPlace place;
  place.name = name;
  place.center = center.head<2>();
  place.size = size;
  place.outline = polygon;
  if (polygon.empty()) {
    const Eigen::Rotation2Dd rotation(yaw);
    for (const auto& [x, y] : {std::pair(-0.5, -0.5), std::pair(0.5, -0.5), std::pair(0.5, 0.5), std::pair(-0.5, 0.5)}) {
      place.outline.push_back(place.center + rotation * Eigen::Vector2d(x * size.x(), y * size.y()));
    }
  }
  place.area = signed_area(place.outline);
  return place;
}

DrawnPlace with_holes(DrawnPlace place, const std::vector<std::vector<Eigen::Vector2d>>& holes) {
  place.holes = holes;
  place.area = signed_area(place.outline, holes);
  return place;
}

// Where a corridor's name does not lie in another one that crosses it.
Eigen::Vector2d label_beside_crossings(const SceneCorridor& corridor, const std::map<CorridorId, SceneCorridor>& all) {
  const auto crossed = [&](const Eigen::Vector2d& p) {
    return std::any_of(all.begin(), all.end(), [&](const auto& entry) {
      const SceneCorridor& other = entry.second;
      const Eigen::Vector2d off = Eigen::Rotation2Dd(-other.yaw) * (p - other.center.template head<2>());
      constexpr double margin = 1.0;  // half a name [m]
      return other.id != corridor.id && std::abs(off.x()) < 0.5 * other.length + margin && std::abs(off.y()) < 0.5 * other.width + margin;
    });
  };
  const Eigen::Vector2d along(std::cos(corridor.yaw), std::sin(corridor.yaw));
  for (const double share : {0.0, 0.25, -0.25, 0.125, -0.125, 0.375, -0.375}) {
    Eigen::Vector2d p = corridor.center.head<2>() + share * corridor.length * along;
    if (!crossed(p)) return p;
  }
  return corridor.center.head<2>();
}

// The cells of one kind, neighbours in a row joined.
std::vector<Segment2d> rows_of(const OccupancyGrid& grid, std::int8_t kind) {
  std::vector<Segment2d> rows;
  for (int y = 0; y < grid.height; ++y) {
    int begin = -1;
    for (int x = 0; x <= grid.width; ++x) {
      const bool inside =
          x < grid.width && grid.cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width) + static_cast<std::size_t>(x)] == kind;
      if (inside && begin < 0) begin = x;
      if (inside || begin < 0) continue;
      const auto center = [&](int column) -> Eigen::Vector2d { return grid.origin + grid.resolution * Eigen::Vector2d(column + 0.5, y + 0.5); };
      rows.emplace_back(center(begin), center(x - 1));
      begin = -1;
    }
  }
  return rows;
}

}  // namespace

FloorPlan make_floor_plan(const GraphSnapshot& snapshot, const OccupancyGrid& grid, const Trajectory& path) {
  FloorPlan plan;
  plan.yaw = std::remainder(snapshot.dominant_yaw, M_PI_2);
  plan.cell = grid.resolution;
  plan.obstacles = rows_of(grid, OccupancyGrid::occupied);
  plan.free = rows_of(grid, OccupancyGrid::free);
  plan.walls = walls_of(snapshot, grid, !plan.obstacles.empty());
  std::set<CorridorId> parts;
  for (const SceneBranching& branching : snapshot.branchings) {
    parts.insert(branching.parts.begin(), branching.parts.end());
    plan.places.push_back(with_holes(place("", Eigen::Vector3d::Zero(), Eigen::Vector2d::Zero(), 0, branching.polygon), branching.holes));
    plan.places.back().corridor = true;
  }
  for (const auto& [id, corridor] : snapshot.corridors) {
    plan.places.push_back(
        place("Corridor " + std::to_string(id.value), corridor.center, {corridor.length, corridor.width}, corridor.yaw, corridor.polygon));
    plan.places.back().corridor = true;
    if (parts.count(id) == 0) continue;
    plan.places.back().part = true;
    plan.places.back().center = label_beside_crossings(corridor, snapshot.corridors);
  }
  for (const auto& [id, room] : snapshot.rooms)
    plan.places.push_back(with_holes(place("Room " + std::to_string(id.value), room.center, room.width, room.yaw, room.polygon), room.holes));
  for (const auto& [id, door] : snapshot.doors)
    plan.doors.push_back({"Door " + std::to_string(id.value), door.position.head<2>(), door.yaw, door.width, door.height});
  for (const StampedPose& pose : path) plan.path.push_back(pose.pose.translation.head<2>());
  return plan;
}

}  // namespace sgraph
