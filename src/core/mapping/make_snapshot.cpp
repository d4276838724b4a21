#include "sgraph_slam/core/mapping/make_snapshot.hpp"

#include <map>

#include "sgraph_slam/core/graph/serialization.hpp"
#include "storey_heights.hpp"

namespace sgraph {
namespace {

void add_planes(const MapState& state, bool with_observations, GraphSnapshot& snapshot) {
  for (const auto& [id, record] : state.planes.map.records()) {
    const Plane* plane = state.graph.find(id);
    if (!plane) continue;
    ScenePlane& scene = snapshot.planes[id];
    scene.id = id;
    scene.plane = *plane;
    scene.plane_class = record.plane_class;
    const auto covariance = state.plane_covariances.find(id);
    scene.covariance = covariance != state.plane_covariances.end() ? covariance->second : record.last_covariance;
    scene.extent = record.outline;
    scene.keyframes = record.keyframes;
    scene.storey = record.storey;
    if (!with_observations) continue;
    for (const PlaneObservation& seen : record.observations) scene.observations.push_back({seen.keyframe, seen.outline_base});
  }
}

// A side that is mostly a gap is the door that lies in it, or an opening.
std::vector<SceneSide> sides_of(const MapState& state, const PlaceOutline& outline, int storey) {
  std::vector<SceneSide> sides;
  const Polygon2d& polygon = outline.polygon;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const PlaceSide& found = outline.sides[i];
    SceneSide side;
    if (found.opening > 0.5) {
      side.kind = SceneSide::Kind::opening;
      for (const auto& [id, record] : state.layer.doors()) {
        const Polygon2d line{polygon[i], polygon[(i + 1) % polygon.size()]};
        if (record.storey != storey || distance_to_outline(line, record.door.position) > 0.5) continue;
        side.kind = SceneSide::Kind::door;
        side.door = id;
      }
    } else if (found.plane.valid()) {
      side.kind = SceneSide::Kind::wall;
      side.plane = state.graph.representative(found.plane);
    }
    sides.push_back(side);
  }
  return sides;
}

StoreyHeights heights_of(const MapState& state, int storey) {
  const auto known = state.layer.storeys().find(storey);
  return known == state.layer.storeys().end() ? StoreyHeights{} : known->second;
}

double middle_height(const StoreyHeights& storey) { return storey.ceiling_seen ? 0.5 * (storey.floor + storey.ceiling) : storey.floor; }

void add_room(const MapState& state, RoomId id, const PlaceRecord& record, GraphSnapshot& snapshot) {
  SceneRoom& scene = snapshot.rooms[id];
  scene.id = id;
  scene.polygon = record.place.outline.polygon;
  scene.edges = sides_of(state, record.place.outline, record.storey);
  scene.holes = hole_polygons(record.place.outline);
  scene.storey = record.storey;
  const Room* room = state.graph.find(id);
  if (record.place.kind == PlaceKind::room && room != nullptr) {
    scene.center = room->center();
    scene.width = room->width;
    scene.yaw = room->yaw;
    for (const PlaneId wall : record.place.walls) scene.planes.push_back(state.graph.representative(wall));
    return;
  }
  const Eigen::Vector2d reference = record.place.reference_point();
  scene.center = {reference.x(), reference.y(), room != nullptr ? room->z : middle_height(heights_of(state, record.storey))};
  scene.yaw = record.place.area.yaw;
  for (const SceneSide& side : scene.edges) {
    if (side.kind == SceneSide::Kind::wall) scene.planes.push_back(side.plane);
  }
}

void add_places(const MapState& state, GraphSnapshot& snapshot) {
  for (const auto& [id, record] : state.layer.rooms()) add_room(state, id, record, snapshot);
  for (const auto& [id, record] : state.layer.corridors()) {
    const Corridor* corridor = state.graph.find(id);
    if (!corridor) continue;
    SceneCorridor& scene = snapshot.corridors[id];
    scene.id = id;
    scene.center = corridor->center();
    scene.width = corridor->width;
    scene.yaw = corridor->yaw;
    scene.length = record.place.area.size.x();
    scene.planes = {state.graph.representative(record.place.walls[0]), state.graph.representative(record.place.walls[1])};
    scene.polygon = record.place.outline.polygon;
    scene.edges = sides_of(state, record.place.outline, record.storey);
    scene.storey = record.storey;
  }
  for (const BranchingRecord& record : state.layer.branchings())
    snapshot.branchings.push_back(
        {record.parts, record.outline.polygon, sides_of(state, record.outline, record.storey), record.storey, hole_polygons(record.outline)});
  for (const auto& [id, record] : state.layer.doors()) {
    const FoundDoor& door = record.door;
    snapshot.doors[id] = {id,       record.from, record.to,   {door.position.x(), door.position.y(), heights_of(state, record.storey).floor},
                          door.yaw, door.width,  door.height, record.storey};
  }
  const bool several = state.layer.storeys().size() > 1;
  if (!several && state.layer.rooms().empty() && state.layer.corridors().empty()) return;
  const std::map<int, double> sigmas = storey_height_sigmas(state);
  for (const auto& [number, storey] : state.layer.storeys()) {
    const auto sigma = sigmas.find(number);
    const bool known = sigma != sigmas.end();
    snapshot.storeys.push_back({number, storey.floor, storey.ceiling, known, known ? sigma->second : 0});
  }
}

}  // namespace

GraphSnapshotPtr make_snapshot(const MapState& state, std::int64_t version, const SolveSummary& solve, bool with_factors) {
  auto snapshot = std::make_shared<GraphSnapshot>();
  snapshot->version = version;
  snapshot->T_map_odom = state.T_map_odom;
  snapshot->dominant_yaw = state.planes.frame.yaw;
  for (const auto& [id, keyframe] : state.keyframes) {
    snapshot->keyframes.emplace_hint(snapshot->keyframes.end(), id, keyframe)->second.T_map_base = *state.graph.find(id);
  }
  add_planes(state, with_factors, *snapshot);
  add_places(state, *snapshot);
  snapshot->openings = state.openings;
  if (with_factors) {
    snapshot->factors_json = factors_to_json(state.graph);
    snapshot->decisions = state.log;
  }
  snapshot->last_solve = solve;
  return snapshot;
}

}  // namespace sgraph
