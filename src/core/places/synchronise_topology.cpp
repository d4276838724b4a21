#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/places/topological_layer.hpp"

namespace sgraph {
namespace {

constexpr std::array<RoomSide, 4> room_sides{RoomSide::x_low, RoomSide::x_high, RoomSide::y_low, RoomSide::y_high};

constexpr double floor_normal = 0.9;  // vertical part, at least; places ask for walls only

using PairSet = std::set<PlanePair>;

PlanePair ordered(PlaneId a, PlaneId b) { return a < b ? PlanePair{a, b} : PlanePair{b, a}; }

// Which walls are to be parallel, which perpendicular.
struct Relations {
  PairSet parallel;
  PairSet perpendicular;
};

// Whether two walls are at an angle of which `off` is the sine, as far as their directions are known: many views know a direction well, and a wall
// that is then seen to be oblique is left alone.
bool within_uncertainty(const PlaneMap& planes, PlaneId a, PlaneId b, double off, const TopologyParams& params) {
  const PlaneRecord* first = planes.find(a);
  const PlaneRecord* second = planes.find(b);
  if (first == nullptr || second == nullptr || first->keyframes.empty() || second->keyframes.empty()) return false;
  const double sigma =
      params.view_angle_sigma * std::sqrt(1 / static_cast<double>(first->keyframes.size()) + 1 / static_cast<double>(second->keyframes.size()));
  return std::abs(off) <= params.angle_gate * sigma;
}

Relations wanted_relations(const Graph& graph, const TopologicalLayer& layer, const PlaneMap& planes, const TopologyParams& params) {
  Relations wanted;
  const auto add = [&](PairSet& set, PlaneId a, PlaneId b) {
    const Plane* first = graph.find(a);
    const Plane* second = graph.find(b);
    if (a == b || first == nullptr || second == nullptr) return;
    const Eigen::Vector2d n = first->normal.head<2>().normalized();
    const Eigen::Vector2d m = second->normal.head<2>().normalized();
    const double off = &set == &wanted.parallel ? n.x() * m.y() - n.y() * m.x() : n.dot(m);
    if (within_uncertainty(planes, a, b, off, params)) set.insert(ordered(a, b));
  };
  for (const auto& [id, room] : layer.rooms()) {
    if (room.place.kind != PlaceKind::room) continue;
    const auto& w = room.place.walls;
    add(wanted.parallel, w[low_x], w[high_x]);
    add(wanted.parallel, w[low_y], w[high_y]);
    for (const Side x : {low_x, high_x}) {
      for (const Side y : {low_y, high_y}) add(wanted.perpendicular, w[x], w[y]);
    }
  }
  for (const auto& [id, corridor] : layer.corridors()) add(wanted.parallel, corridor.place.walls[0], corridor.place.walls[1]);
  if (!params.parallel_factors) wanted.parallel.clear();
  if (!params.perpendicular_factors) wanted.perpendicular.clear();
  return wanted;
}

// Removes factors that no place wants any more, adds those that are missing.
template <class FactorType>
void synchronise_pairs(const Graph& graph, PairSet wanted, const TopologyParams& params, const std::set<PlanePair>& keep, Transaction& edit) {
  for (const auto& [id, factor] : graph.factors()) {
    const auto* pair = std::get_if<FactorType>(&factor.data);
    if (!pair) continue;
    const PlanePair planes = ordered(pair->a, pair->b);
    if (wanted.erase(planes) == 0 && keep.count(planes) == 0) edit.remove_factors.push_back(id);
  }
  for (const PlanePair& planes : wanted) {
    if (!graph.find(planes.first) || !graph.find(planes.second)) continue;
    add_factor(edit, FactorType{planes.first, planes.second, params.angle_sigma}, RobustLoss::cauchy(params.loss_scale));
  }
}

// Pairs whose parallel factors no place asks for: the faces of one wall, where they belong to the thickness, and floors and ceilings
// of two storeys, or of a storey and the stairs.
std::set<PlanePair> other_parallels(const Graph& graph) {
  std::set<PlanePair> pairs;
  for (const auto& [id, factor] : graph.factors()) {
    if (const auto* wall = std::get_if<WallThickness>(&factor.data)) pairs.insert(ordered(wall->a, wall->b));
    const auto* parallel = std::get_if<ParallelPlanes>(&factor.data);
    if (parallel != nullptr && std::abs(graph.find(parallel->a)->normal.z()) > floor_normal) pairs.insert(ordered(parallel->a, parallel->b));
  }
  return pairs;
}

// The wall factors that a place has, against those that it should have: `wanted` maps a wall's plane to its side.
template <class FactorType, class PlaceId, class SideType>
void synchronise_walls(const Graph& graph, PlaceId place, std::set<std::pair<PlaneId, SideType>> wanted, double sigma, Transaction& edit) {
  for (const FactorId id : graph.factors_of(place)) {
    const auto* wall = std::get_if<FactorType>(&graph.find(id)->data);
    if (wall && wanted.erase({wall->plane, wall->side}) == 0) edit.remove_factors.push_back(id);
  }
  for (const auto& [plane, side] : wanted) {
    if (graph.find(plane)) add_factor(edit, FactorType{place, plane, side, sigma});
  }
}

}  // namespace

Transaction synchronise_topology(const Graph& graph, const TopologicalLayer& layer, const PlaneMap& planes, const PlaceHeights& heights,
                                 const TopologyParams& params) {
  Transaction edit;
  edit.reason = "rooms and corridors";
  const auto height = [](const auto& map, auto id) {
    const auto found = map.find(id);
    return found == map.end() ? 0.0 : found->second;
  };
  for (const auto& [id, value] : graph.rooms()) {
    const auto room = layer.rooms().find(id);
    if (room == layer.rooms().end() || !room->second.place.has_node()) edit.remove_variables.emplace_back(id);
  }
  for (const auto& [id, value] : graph.corridors()) {
    if (layer.corridors().count(id) == 0) edit.remove_variables.emplace_back(id);
  }
  for (const auto& [id, room] : layer.rooms()) {
    if (!room.place.has_node()) continue;
    const auto& area = room.place.area;
    if (!graph.find(id)) edit.rooms[id] = Room::at({area.center.x(), area.center.y(), height(heights.rooms, id)}, area.yaw, area.size);
    std::set<std::pair<PlaneId, RoomSide>> walls;
    for (const RoomSide side : room_sides) walls.emplace(room.place.walls[static_cast<std::size_t>(side)], side);
    synchronise_walls<RoomPlane>(graph, id, std::move(walls), params.wall_sigma, edit);
  }
  for (const auto& [id, corridor] : layer.corridors()) {
    const auto& area = corridor.place.area;
    if (!graph.find(id))
      edit.corridors[id] = Corridor::at({area.center.x(), area.center.y(), height(heights.corridors, id)}, area.yaw, area.size.y());
    synchronise_walls<CorridorPlane>(
        graph, id,
        std::set<std::pair<PlaneId, CorridorSide>>{{corridor.place.walls[0], CorridorSide::right}, {corridor.place.walls[1], CorridorSide::left}},
        params.wall_sigma, edit);
  }
  Relations wanted = wanted_relations(graph, layer, planes, params);
  synchronise_pairs<ParallelPlanes>(graph, std::move(wanted.parallel), params, other_parallels(graph), edit);
  synchronise_pairs<PerpendicularPlanes>(graph, std::move(wanted.perpendicular), params, {}, edit);
  return edit;
}

}  // namespace sgraph
