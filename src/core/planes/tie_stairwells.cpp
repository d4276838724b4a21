#include "sgraph_slam/core/planes/tie_stairwells.hpp"

#include <cmath>
#include <optional>
#include <set>
#include <vector>

#include "sgraph_slam/core/planes/level_floors.hpp"
#include "sgraph_slam/core/planes/merging.hpp"
#include "sgraph_slam/core/types/storey.hpp"

namespace sgraph {
namespace {

constexpr std::size_t known_after = 3;  // of either plane
constexpr double smallest_level = 2;    // [m^2]: no step, and wide enough to tell a tilt
constexpr double same_height = 0.08;    // [m] half a step
constexpr double same_tilt = 0.02;      // [rad] a landing may slope by that for its water
constexpr double sigma_tilt = 0.001;    // [rad] and
constexpr double sigma_height = 0.005;  // [m] of one surface, seen at different angles by beams that are off
constexpr double gives_way = 2.5;       // of sigma

struct Level {
  PlaneId id;
  const Plane* plane;
  const Outline* outline;
};

std::vector<Level> levels_of(const Graph& graph, const PlaneMap& planes, bool of_stairwell) {
  std::vector<Level> levels;
  for (const auto& [id, record] : planes.records()) {
    const Plane* plane = graph.find(id);
    if (plane == nullptr || (record.storey == stairwell) != of_stairwell || record.plane_class != PlaneClass::horizontal) continue;
    if (record.keyframes.size() >= known_after && outline_area(record.outline) >= smallest_level) levels.push_back({id, plane, &record.outline});
  }
  return levels;
}

// How far the storey's plane is from the stairwell's where that was seen [m]; none where they can't be one surface.
std::optional<double> apart(const Level& stairs, const Level& storey) {
  if (stairs.plane->normal.dot(storey.plane->normal) < std::cos(same_tilt)) return std::nullopt;
  const double distance = std::abs(storey.plane->normal.dot(outline_center(*stairs.outline)) + storey.plane->d);
  if (distance > same_height || outline_distance(*storey.plane, *stairs.outline, *storey.outline) > 0) return std::nullopt;
  return distance;
}

}  // namespace

int tie_stairwells(Committer& committer, const PlaneMap& planes) {
  const Graph& graph = committer.graph;
  const std::vector<Level> of_stairs = levels_of(graph, planes, true);
  if (of_stairs.empty()) return 0;
  std::set<PlanePair> tied;
  for (const auto& [id, factor] : graph.factors()) {
    if (const auto* pair = std::get_if<AlignedWalls>(&factor.data)) tied.insert({pair->a, pair->b});
  }
  const std::vector<Level> of_storeys = levels_of(graph, planes, false);
  Transaction edit;
  edit.reason = "seen from the stairs and from the storey";
  int count = 0;
  for (const Level& stairs : of_stairs) {
    const Level* nearest = nullptr;
    double least = same_height;
    for (const Level& storey : of_storeys) {
      const std::optional<double> distance = apart(stairs, storey);
      if (!distance || *distance > least) continue;
      least = *distance;
      nearest = &storey;
    }
    if (nearest == nullptr || tied.count({nearest->id, stairs.id}) > 0) continue;
    const Eigen::Vector3d at = outline_center(*stairs.outline);
    add_factor(edit, ParallelPlanes{nearest->id, stairs.id, sigma_tilt}, RobustLoss::huber(gives_way));
    add_factor(edit, at_height(nearest->id, stairs.id, at, 0, sigma_height), RobustLoss::huber(gives_way));
    ++count;
  }
  return count == 0 || !committer.commit(edit).ok() ? 0 : count;
}

}  // namespace sgraph
