#include "sgraph_slam/core/io/occupancy_grid.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>

#include "sgraph_slam/core/io/map_cloud.hpp"
#include "sgraph_slam/core/math/walk_cells.hpp"

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
               const LeaveOut& left_out) {
  const Pose T_map_lidar = keyframe.T_map_base * T_base_lidar;
  const Eigen::Vector3d& origin = T_map_lidar.translation;
  const double lidar_height = floor.distance(origin);
  const double low = std::min(params.grid_low, 0.5 * lidar_height);
  const double high = std::max(params.grid_high, lidar_height + 0.05);
  const auto cell_of = [&params](const Eigen::Vector3d& p) -> Cell { return (p.head<2>() / params.grid_resolution).array().floor().cast<int>(); };
  const Eigen::Matrix3d rotation = T_map_lidar.matrix();
  Sweep sweep;
  sweep.origin = origin.head<2>() / params.grid_resolution;
  for (const Point& point : cloud.points) {
    const Eigen::Vector3d p = rotation * point.position().cast<double>() + origin;
    if (!p.allFinite() || p.cwiseAbs().maxCoeff() > max_coordinate) continue;
    const double height = floor.distance(p);
    if (left_out && left_out(p)) continue;
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

// Odds of the cells of a raster that grows as it must.
class Carver {
 public:
  // Makes room for cells, with `margin` cells around them when it must grow.
  void hold(const Eigen::AlignedBox2i& cells, int margin) {
    if (cells.isEmpty() || bounds_.contains(cells)) return;
    Carver grown;
    grown.bounds_ = bounds_.merged(Eigen::AlignedBox2i(cells.min().array() - margin, cells.max().array() + margin));
    grown.odds_.assign(static_cast<std::size_t>(grown.width()) * static_cast<std::size_t>(grown.height()), 0);
    grown.mark_.assign(grown.odds_.size(), 0);
    if (!bounds_.isEmpty()) {
      for (int y = bounds_.min().y(); y <= bounds_.max().y(); ++y) {
        const auto row = odds_.begin() + static_cast<std::ptrdiff_t>(index({bounds_.min().x(), y}));
        std::copy(row, row + width(), grown.odds_.begin() + static_cast<std::ptrdiff_t>(grown.index({bounds_.min().x(), y})));
      }
    }
    *this = std::move(grown);
  }

  // What a keyframe says, or, with `sign` -1, no longer says. Its cells are held already.
  void add(const Sweep& sweep, int sign = 1) {
    mark_hit_ += 2;
    mark_passed_ = mark_hit_ + 1;
    for (const Cell& cell : sweep.hits) {
      mark_[index(cell)] = mark_hit_;
      odds_[index(cell)] += static_cast<float>(sign * hit_odds);
    }
    for (const Cell& cell : sweep.hits) carve(sweep.origin, cell, sign);
    for (const Cell& cell : sweep.passes) carve(sweep.origin, cell, sign);
  }

  // The cells in words; odds smaller than `nothing` are what rounding left of nothing.
  [[nodiscard]] OccupancyGrid grid(double resolution, float nothing) const {
    OccupancyGrid grid;
    grid.resolution = resolution;
    if (bounds_.isEmpty()) return grid;
    grid.origin = resolution * bounds_.min().cast<double>();
    grid.width = width();
    grid.height = height();
    grid.cells.assign(odds_.size(), OccupancyGrid::unknown);
    for (std::size_t i = 0; i < odds_.size(); ++i) {
      if (std::abs(odds_[i]) > nothing) grid.cells[i] = odds_[i] > 0 ? OccupancyGrid::occupied : OccupancyGrid::free;
    }
    return grid;
  }

 private:
  [[nodiscard]] int width() const { return bounds_.sizes().x() + 1; }
  [[nodiscard]] int height() const { return bounds_.sizes().y() + 1; }
  [[nodiscard]] std::size_t index(const Cell& cell) const {
    return static_cast<std::size_t>(cell.y() - bounds_.min().y()) * static_cast<std::size_t>(width()) +
           static_cast<std::size_t>(cell.x() - bounds_.min().x());
  }

  // Walks the cells from the origin to the end cell; an obstacle that this keyframe saw on the way ends the view (the points of a keyframe come
  // from scans taken at slightly different places, and must not see round corners).
  void carve(const Eigen::Vector2d& from, const Cell& end, int sign) {
    const Eigen::Vector2d corner = bounds_.min().cast<double>();
    const Eigen::Vector2d to = end.cast<double>() + Eigen::Vector2d(0.5, 0.5);
    const auto odds = static_cast<float>(sign * miss_odds);
    walk_cells<2>(from - corner, to - corner, {1, width()}, [&](std::ptrdiff_t i, std::int64_t, std::int64_t) {
      std::int32_t& mark = mark_[static_cast<std::size_t>(i)];
      if (mark == mark_hit_) return false;
      if (mark != mark_passed_) {
        mark = mark_passed_;
        odds_[static_cast<std::size_t>(i)] += odds;
      }
      return true;
    });
  }

  Eigen::AlignedBox2i bounds_;  // first and last cell
  std::vector<float> odds_;
  std::vector<std::int32_t> mark_;
  std::int32_t mark_hit_ = 0;
  std::int32_t mark_passed_ = 1;
};

Eigen::AlignedBox2i bounds_of(const Sweep& sweep) {
  Eigen::AlignedBox2i bounds;
  bounds.extend(Cell(sweep.origin.array().floor().cast<int>()));
  for (const auto* cells : {&sweep.hits, &sweep.passes}) {
    for (const Cell& cell : *cells) bounds.extend(cell);
  }
  return bounds;
}

Eigen::AlignedBox2i bounds_of(const std::vector<Sweep>& sweeps) {
  Eigen::AlignedBox2i bounds;
  for (const Sweep& sweep : sweeps) bounds.extend(bounds_of(sweep));
  return bounds;
}

std::int64_t area(const Eigen::AlignedBox2i& bounds) {
  if (bounds.isEmpty()) return 0;  // its sizes would overflow
  return (std::int64_t{bounds.sizes().x()} + 3) * (std::int64_t{bounds.sizes().y()} + 3);
}

}  // namespace

std::int8_t OccupancyGrid::at(const Eigen::Vector2d& p) const {
  const Eigen::Vector2d cell = ((p - origin) / resolution).array().floor();
  if (!(cell.x() >= 0 && cell.y() >= 0 && cell.x() < width && cell.y() < height)) return unknown;
  return cells[static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(width) + static_cast<std::size_t>(cell.x())];
}

OccupancyGrid make_occupancy_grid(const GraphSnapshot& snapshot, const Pose& T_base_lidar, const OutputParams& params, const LeaveOut& left_out) {
  std::vector<Sweep> sweeps;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    const auto floor = floor_below(snapshot, keyframe, T_base_lidar);
    const CloudPtr cloud = keyframe.cloud.get();
    if (floor && cloud) sweeps.push_back(sweep_of(keyframe, *cloud, T_base_lidar, *floor, params, left_out));
  }
  double resolution = params.grid_resolution;
  while (area(bounds_of(sweeps)) > max_cells) {
    for (Sweep& sweep : sweeps) coarsen(sweep);
    resolution *= 2;
  }
  Carver carver;
  carver.hold(bounds_of(sweeps), 1);
  for (const Sweep& sweep : sweeps) carver.add(sweep);
  return carver.grid(resolution, 0);
}

class LiveOccupancyGrid::Implementation {
 public:
  explicit Implementation(const OutputParams& params) : params_(params) {}

  void update(const GraphSnapshot& snapshot, const Pose& T_base_lidar) {
    const auto is_gone = [&snapshot](const auto& known) { return snapshot.keyframes.count(known.first) == 0; };
    if (std::any_of(known_.begin(), known_.end(), is_gone)) {  // another map
      known_.clear();
      carver_ = {};
    }
    for (const auto& [id, keyframe] : snapshot.keyframes) {
      const auto before = known_.find(id);
      if (before != known_.end() && is_near(before->second.keyframe.T_map_base, keyframe.T_map_base)) continue;
      const CloudPtr cloud = keyframe.cloud.get();
      const auto floor = floor_below(snapshot, keyframe, T_base_lidar);
      if (!cloud || !floor) continue;
      if (before != known_.end()) carver_.add(sweep_of(before->second.keyframe, *cloud, T_base_lidar, before->second.floor, params_, {}), -1);
      const Sweep sweep = sweep_of(keyframe, *cloud, T_base_lidar, *floor, params_, {});
      if (area(bounds_of(sweep)) > most_live) continue;  // a reflection kilometres away
      carver_.hold(bounds_of(sweep), static_cast<int>(10 / params_.grid_resolution));
      carver_.add(sweep);
      known_[id] = {keyframe, *floor};
    }
  }

  [[nodiscard]] OccupancyGrid grid() const { return carver_.grid(params_.grid_resolution, 1e-3F); }

 private:
  struct Known {
    SceneKeyframe keyframe;  // as it was when it was added
    Plane floor;
  };
  static constexpr std::int64_t most_live = 25'000'000;

  [[nodiscard]] bool is_near(const Pose& a, const Pose& b) const {
    constexpr double reach = 20;  // of what is seen [m]
    return (a.translation - b.translation).norm() + reach * 2 * (a.rotation.conjugate() * b.rotation).vec().norm() < params_.grid_resolution;
  }

  OutputParams params_;
  Carver carver_;
  std::map<KeyframeId, Known> known_;
};

LiveOccupancyGrid::LiveOccupancyGrid(const OutputParams& params) : implementation_(std::make_unique<Implementation>(params)) {}
LiveOccupancyGrid::~LiveOccupancyGrid() = default;
void LiveOccupancyGrid::update(const GraphSnapshot& snapshot, const Pose& T_base_lidar) { implementation_->update(snapshot, T_base_lidar); }
OccupancyGrid LiveOccupancyGrid::grid() const { return implementation_->grid(); }

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
