#include "sgraph_slam/core/planes/level_floors.hpp"

#include <algorithm>
#include <optional>
#include <set>

#include "sgraph_slam/core/types/storey.hpp"

namespace sgraph {
namespace {

constexpr double level = 0.001;   // [rad] to which floors are laid, and to which a large one is seen
constexpr double steep = 0.01;    // [rad] a floor that slopes by more is meant to; stairs leave less tilt than that, a lift may leave more
constexpr double let_go = 5;      // of these: a floor that slopes pulls with a limited force
constexpr std::size_t views = 3;  // of a floor

bool joined(const Graph& graph, const PlaneMap& planes, int storey) {
  return std::any_of(graph.factors().begin(), graph.factors().end(), [&](const auto& entry) {
    const auto* pair = std::get_if<ParallelPlanes>(&entry.second.data);
    if (pair == nullptr) return false;
    const PlaneRecord* a = planes.find(pair->a);
    const PlaneRecord* b = planes.find(pair->b);
    if (a == nullptr || b == nullptr || a->storey == stairwell || b->storey == stairwell) return false;
    return a->storey != b->storey && (a->storey == storey || b->storey == storey);
  });
}

}  // namespace

std::set<int> storeys_of(const PlaneMap& planes) {
  std::set<int> storeys;
  for (const auto& [id, record] : planes.records()) {
    if (record.storey != stairwell) storeys.insert(record.storey);
  }
  return storeys;
}

std::optional<PlaneId> largest_floor(const Graph& graph, const PlaneMap& planes, int storey) {
  std::optional<PlaneId> largest;
  double most = 0;
  for (const auto& [id, record] : planes.records()) {
    const Plane* plane = graph.find(id);
    if (plane == nullptr || record.storey != storey || record.plane_class != PlaneClass::horizontal || plane->normal.z() < 0) continue;
    const double area = outline_area(record.outline);
    if (record.keyframes.size() < views || area <= most) continue;
    most = area;
    largest = id;
  }
  return largest;
}

AlignedWalls at_height(PlaneId a, PlaneId b, const Eigen::Vector3d& at, double rise, double sigma) {
  constexpr double anyhow = 10;  // [m] holds nothing: from one point no tilt is known
  return {a, b, at, at, rise, anyhow, sigma};
}

// Floors touch at a point, walls along a stretch; those that are drawn at one height aren't apart.
bool are_floors_apart(const AlignedWalls& walls) { return walls.from == walls.to && walls.rise != 0; }

int level_floors(Committer& committer, const PlaneMap& planes, const std::set<int>& by_lift) {
  Transaction edit;
  edit.reason = "floors of a building are level";
  std::optional<PlaneId> first;
  for (const int storey : storeys_of(planes)) {
    if (storey == 0 || joined(committer.graph, planes, storey)) continue;
    if (!first) first = largest_floor(committer.graph, planes, 0);
    const std::optional<PlaneId> floor = largest_floor(committer.graph, planes, storey);
    if (!first || !floor) continue;
    const double angle = committer.graph.find(*first)->normal.cross(committer.graph.find(*floor)->normal).norm();
    if (by_lift.count(storey) > 0 || angle < steep) add_factor(edit, ParallelPlanes{*first, *floor, level}, RobustLoss::huber(let_go));
  }
  return edit.factors.empty() || !committer.commit(edit).ok() ? 0 : static_cast<int>(edit.factors.size());
}

}  // namespace sgraph
