#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "sgraph_slam/core/types/ids.hpp"

namespace sgraph {

/// Where planes are, by the boxes around what has been seen of them (map frame), in a grid over the ground: what lies near something is found without
/// asking all.
class PlaneIndex {
 public:
  /// Enters a plane, or moves it; an empty box takes it out.
  void put(PlaneId id, const Eigen::AlignedBox3d& box);
  void erase(PlaneId id) { put(id, {}); }

  /// Planes whose boxes are at most `gap` [m] from the box, by id.
  [[nodiscard]] std::vector<PlaneId> near(const Eigen::AlignedBox3d& box, double gap) const;

 private:
  using Cell = std::pair<std::int64_t, std::int64_t>;

  template <class Visit>
  static void visit_cells(const Eigen::AlignedBox3d& box, Visit visit);

  std::map<PlaneId, Eigen::AlignedBox3d> boxes_;
  std::map<Cell, std::vector<PlaneId>> cells_;
};

}  // namespace sgraph
