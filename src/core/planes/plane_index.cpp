#include "sgraph_slam/core/planes/plane_index.hpp"

#include <algorithm>
#include <cmath>

namespace sgraph {
namespace {
constexpr double cell_size = 4;  // [m]
}

template <class Visit>
void PlaneIndex::visit_cells(const Eigen::AlignedBox3d& box, Visit visit) {
  const auto cell = [](double value) { return static_cast<std::int64_t>(std::floor(value / cell_size)); };
  for (std::int64_t x = cell(box.min().x()); x <= cell(box.max().x()); ++x) {
    for (std::int64_t y = cell(box.min().y()); y <= cell(box.max().y()); ++y) visit(Cell{x, y});
  }
}

void PlaneIndex::put(PlaneId id, const Eigen::AlignedBox3d& box) {
  const auto known = boxes_.find(id);
  if (known != boxes_.end()) {
    visit_cells(known->second, [&](const Cell& cell) {
      const auto at = cells_.find(cell);
      at->second.erase(std::find(at->second.begin(), at->second.end(), id));
      if (at->second.empty()) cells_.erase(at);
    });
    boxes_.erase(known);
  }
  if (box.isEmpty()) return;
  boxes_[id] = box;
  visit_cells(box, [&](const Cell& cell) { cells_[cell].push_back(id); });
}

std::vector<PlaneId> PlaneIndex::near(const Eigen::AlignedBox3d& box, double gap) const {
  std::vector<PlaneId> found;
  if (box.isEmpty()) return found;
  const Eigen::AlignedBox3d wide(box.min() - Eigen::Vector3d::Constant(gap), box.max() + Eigen::Vector3d::Constant(gap));
  // Of a box wider than what is known every plane is asked instead of every cell.
  if (wide.sizes().x() * wide.sizes().y() > cell_size * cell_size * static_cast<double>(cells_.size())) {
    for (const auto& [id, other] : boxes_) found.push_back(id);
  } else {
    visit_cells(wide, [&](const Cell& cell) {
      const auto at = cells_.find(cell);
      if (at != cells_.end()) found.insert(found.end(), at->second.begin(), at->second.end());
    });
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
  }
  const auto is_far = [&](PlaneId id) { return boxes_.at(id).squaredExteriorDistance(box) > gap * gap; };
  found.erase(std::remove_if(found.begin(), found.end(), is_far), found.end());
  return found;
}

}  // namespace sgraph
