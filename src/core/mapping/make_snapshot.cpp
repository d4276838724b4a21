#include "sgraph_slam/core/mapping/make_snapshot.hpp"

#include "sgraph_slam/core/graph/serialization.hpp"

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
    if (!with_observations) continue;
    for (const PlaneObservation& seen : record.observations) scene.observations.push_back({seen.keyframe, seen.outline_base});
  }
}

void add_places(const MapState& state, GraphSnapshot& snapshot) {
  for (const auto& [id, record] : state.layer.rooms()) {
    const Room* room = state.graph.find(id);
    if (!room) continue;
    SceneRoom& scene = snapshot.rooms[id];
    scene.id = id;
    scene.center = room->center();
    scene.width = room->width;
    scene.yaw = room->yaw;
    scene.planes = {record.shape.walls.begin(), record.shape.walls.end()};
  }
  for (const auto& [id, record] : state.layer.corridors()) {
    const Corridor* corridor = state.graph.find(id);
    if (!corridor) continue;
    SceneCorridor& scene = snapshot.corridors[id];
    scene.id = id;
    scene.center = corridor->center();
    scene.width = corridor->width;
    scene.yaw = corridor->yaw;
    scene.length = record.shape.area.size.x();
    scene.planes = {record.shape.walls.begin(), record.shape.walls.end()};
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
