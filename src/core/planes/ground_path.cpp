#include "sgraph_slam/core/planes/ground_path.hpp"

#include <algorithm>
#include <cmath>

namespace sgraph {
namespace {

constexpr double cell_size = 4;    // [m]
constexpr double rounding = 1e-6;  // a step that ends on the line crosses it [m]

template <class Visit>
void visit_cells(const Eigen::Vector2d& a, const Eigen::Vector2d& b, Visit visit) {
  const auto cell = [](double value) { return static_cast<std::int64_t>(std::floor(value / cell_size)); };
  const Eigen::Vector2d low = a.cwiseMin(b).array() - rounding;
  const Eigen::Vector2d high = a.cwiseMax(b).array() + rounding;
  for (std::int64_t x = cell(low.x()); x <= cell(high.x()); ++x) {
    for (std::int64_t y = cell(low.y()); y <= cell(high.y()); ++y) visit(std::pair{x, y});
  }
}

std::vector<Eigen::Vector2d> positions(const Graph& graph) {
  std::vector<Eigen::Vector2d> points;
  for (const auto& [id, T_map_base] : graph.keyframes()) points.emplace_back(T_map_base.translation.head<2>());
  return points;
}

}  // namespace

GroundPath::GroundPath(const Graph& graph) : GroundPath(positions(graph)) {}

GroundPath::GroundPath(std::vector<Eigen::Vector2d> points) { add(points); }

GroundPath::GroundPath(const std::vector<std::vector<Eigen::Vector2d>>& stretches) {
  for (const auto& stretch : stretches) add(stretch);
}

void GroundPath::add(const std::vector<Eigen::Vector2d>& stretch) {
  const std::size_t first = points_.size();
  points_.insert(points_.end(), stretch.begin(), stretch.end());
  for (std::size_t i = first + 1; i < points_.size(); ++i) {
    visit_cells(points_[i - 1], points_[i], [&](const Cell& cell) { cells_[cell].push_back(i); });
  }
}

std::vector<std::size_t> GroundPath::steps_near(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  std::vector<std::size_t> found;
  // In pieces of a cell's size: the box around a long oblique line would hold the whole building.
  const int pieces = std::max(1, static_cast<int>(std::ceil((to - from).norm() / cell_size)));
  for (int i = 0; i < pieces; ++i) {
    const Eigen::Vector2d a = from + (to - from) * i / pieces;
    const Eigen::Vector2d b = from + (to - from) * (i + 1) / pieces;
    visit_cells(a, b, [&](const Cell& cell) {
      const auto at = cells_.find(cell);
      if (at != cells_.end()) found.insert(found.end(), at->second.begin(), at->second.end());
    });
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace sgraph
