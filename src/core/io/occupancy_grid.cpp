#include "sgraph_slam/core/io/occupancy_grid.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>

#include "sgraph_slam/core/io/map_cloud.hpp"

namespace sgraph {
namespace {

// Log odds of one keyframe's word (hit 0.7, seen through 0.4: the usual inverse sensor model).
constexpr double hit_odds = 0.85;
constexpr double miss_odds = -0.4;
constexpr std::int64_t max_cells = 100'000'000;
constexpr double max_coordinate = 1e6;  // [m]; farther is no map of a building

using Cell = Eigen::Vector2i;  // of the raster with a corner at the map's origin

// What one keyframe says: cells where rays end.
struct Sweep {
  Eigen::Vector2d origin;    // of the rays [cells]
  std::vector<Cell> hits;    // on an obstacle
  std::vector<Cell> passes;  // where a ray left the band unhindered
};

void sort_and_thin(std::vector<Cell>& cells) {
  std::sort(cells.begin(), cells.end(), [](const Cell& a, const Cell& b) { return a.y() != b.y() ? a.y() < b.y() : a.x() < b.x(); });
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  cells.shrink_to_fit();
}

Sweep sweep_of(const SceneKeyframe& keyframe, const Cloud& cloud, const Pose& T_base_lidar, const Plane& floor, const OutputParams& params,
               const SeenThrough* gone) {
  const Pose T_map_lidar = keyframe.T_map_base * T_base_lidar;
  const Eigen::Vector3d& origin = T_map_lidar.translation;
  const double lidar_height = floor.distance(origin);
  const double low = std::min(params.grid_low, 0.5 * lidar_height);
  const double high = std::max(params.grid_high, lidar_height + 0.05);
  const auto cell_of = [&params](const Eigen::Vector3d& p) -> Cell { return (p.head<2>() / params.grid_resolution).array().floor().cast<int>(); };
  Sweep sweep;
  sweep.origin = origin.head<2>() / params.grid_resolution;
  for (const Point& point : cloud.points) {
    const Eigen::Vector3d p = T_map_lidar * point.position().cast<double>();
    if (!p.allFinite() || p.cwiseAbs().maxCoeff() > max_coordinate) continue;
    const double height = floor.distance(p);
    if (gone != nullptr && (*gone)(p)) continue;
    if (height >= low && height <= high) {
      sweep.hits.push_back(cell_of(p));
    } else {
      const double fraction = ((height < low ? low : high) - lidar_height) / (height - lidar_height);
      sweep.passes.push_back(cell_of(origin + fraction * (p - origin)));
    }
  }
  sort_and_thin(sweep.hits);
  sort_and_thin(sweep.passes);
  return sweep;
}

// The same on a raster of twice the cell size.
void coarsen(Sweep& sweep) {
  sweep.origin /= 2;
  for (auto* cells : {&sweep.hits, &sweep.passes}) {
    for (Cell& cell : *cells) cell = {cell.x() >> 1, cell.y() >> 1};
    sort_and_thin(*cells);
  }
}

class Carver {
 public:
  Carver(OccupancyGrid& grid, const Cell& first) : grid_(grid), first_(first), odds_(grid.cells.size(), 0), mark_(grid.cells.size(), 0) {}

  void add(const Sweep& sweep) {
    mark_hit_ += 2;
    mark_passed_ = mark_hit_ + 1;
    for (const Cell& cell : sweep.hits) {
      mark_[index(cell)] = mark_hit_;
      odds_[index(cell)] += static_cast<float>(hit_odds);
    }
    for (const Cell& cell : sweep.hits) carve(sweep.origin, cell);
    for (const Cell& cell : sweep.passes) carve(sweep.origin, cell);
  }

  void finish() {
    for (std::size_t i = 0; i < odds_.size(); ++i) {
      if (odds_[i] != 0) grid_.cells[i] = odds_[i] > 0 ? OccupancyGrid::occupied : OccupancyGrid::free;
    }
  }

 private:
  [[nodiscard]] std::size_t index(const Cell& cell) const {
    return static_cast<std::size_t>(cell.y() - first_.y()) * static_cast<std::size_t>(grid_.width) + static_cast<std::size_t>(cell.x() - first_.x());
  }

  // Walks the cells from the origin to the end cell; an obstacle that this keyframe saw on the way ends the view (the points of a keyframe come
  // from scans taken at slightly different places, and must not see round corners).
  void carve(const Eigen::Vector2d& from, const Cell& end) {
    const Eigen::Vector2d way = end.cast<double>() + Eigen::Vector2d(0.5, 0.5) - from;
    Cell cell = from.array().floor().cast<int>();
    const Cell step(way.x() < 0 ? -1 : 1, way.y() < 0 ? -1 : 1);
    Eigen::Vector2d next;   // where along the way the next column and row begin
    Eigen::Vector2d delta;  // from one to the next
    for (int k = 0; k < 2; ++k) {
      const bool still = std::abs(way[k]) < 1e-9;
      delta[k] = still ? std::numeric_limits<double>::infinity() : 1 / std::abs(way[k]);
      next[k] = still ? delta[k] : (way[k] < 0 ? from[k] - cell[k] : cell[k] + 1 - from[k]) * delta[k];
    }
    while (true) {
      auto& mark = mark_[index(cell)];
      if (mark == mark_hit_) return;
      if (mark != mark_passed_) {
        mark = mark_passed_;
        odds_[index(cell)] += static_cast<float>(miss_odds);
      }
      const int k = next.x() < next.y() ? 0 : 1;
      if (cell == end || next[k] > 1) return;
      cell[k] += step[k];
      next[k] += delta[k];
    }
  }

  OccupancyGrid& grid_;
  Cell first_;
  std::vector<float> odds_;
  std::vector<std::int32_t> mark_;
  std::int32_t mark_hit_ = 0;
  std::int32_t mark_passed_ = 1;
};

Eigen::AlignedBox2i bounds_of(const std::vector<Sweep>& sweeps) {
  Eigen::AlignedBox2i bounds;
  for (const Sweep& sweep : sweeps) {
    bounds.extend(Cell(sweep.origin.array().floor().cast<int>()));
    for (const auto* cells : {&sweep.hits, &sweep.passes}) {
      for (const Cell& cell : *cells) bounds.extend(cell);
    }
  }
  return bounds;
}

std::int64_t area(const Eigen::AlignedBox2i& bounds) { return (std::int64_t{bounds.sizes().x()} + 3) * (std::int64_t{bounds.sizes().y()} + 3); }

}  // namespace

std::int8_t OccupancyGrid::at(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d cell = ((p - origin) / resolution).array().floor();
  if (!(cell.x() >= 0 && cell.y() >= 0 && cell.x() < width && cell.y() < height)) return unknown;
  return cells[static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(width) + static_cast<std::size_t>(cell.x())];
}

OccupancyGrid make_occupancy_grid(const GraphSnapshot& snapshot, const Pose& T_base_lidar, const OutputParams& params, const SeenThrough* gone) {
  std::vector<Sweep> sweeps;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    const auto floor = floor_below(snapshot, keyframe, T_base_lidar);
    const CloudPtr cloud = keyframe.cloud.get();
    if (floor && cloud) sweeps.push_back(sweep_of(keyframe, *cloud, T_base_lidar, *floor, params, gone));
  }
  OccupancyGrid grid;
  grid.resolution = params.grid_resolution;
  if (sweeps.empty()) return grid;
  while (area(bounds_of(sweeps)) > max_cells) {
    for (Sweep& sweep : sweeps) coarsen(sweep);
    grid.resolution *= 2;
  }
  const Eigen::AlignedBox2i bounds = bounds_of(sweeps);
  const Cell first = bounds.min() - Cell(1, 1);  // with a margin of one cell
  grid.origin = grid.resolution * first.cast<double>();
  grid.width = bounds.sizes().x() + 3;
  grid.height = bounds.sizes().y() + 3;
  grid.cells.assign(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height), OccupancyGrid::unknown);
  Carver carver(grid, first);
  for (const Sweep& sweep : sweeps) carver.add(sweep);
  carver.finish();
  return grid;
}

std::string pgm_bytes(const OccupancyGrid& grid) {
  std::string bytes = "P5\n" + std::to_string(grid.width) + ' ' + std::to_string(grid.height) + "\n255\n";
  bytes.reserve(bytes.size() + grid.cells.size());
  for (int y = grid.height - 1; y >= 0; --y) {
    for (int x = 0; x < grid.width; ++x) {
      const std::int8_t cell = grid.cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width) + static_cast<std::size_t>(x)];
      bytes += static_cast<char>(cell == OccupancyGrid::unknown ? 205 : cell == OccupancyGrid::free ? 254 : 0);
    }
  }
  return bytes;
}

std::string map_yaml(const OccupancyGrid& grid, const std::string& image) {
  std::ostringstream text;
  text << std::setprecision(12) << "image: " << image << "\nresolution: " << grid.resolution << "\norigin: [" << grid.origin.x() << ", "
       << grid.origin.y() << ", 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
  return text.str();
}

}  // namespace sgraph
