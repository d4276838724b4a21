#include "sgraph_slam/core/localisation/taken_map.hpp"

#include <algorithm>
#include <optional>

#include "sgraph_slam/core/graph/serialization.hpp"
#include "sgraph_slam/core/store/stored_clouds.hpp"

namespace sgraph {
namespace {

// Whether a factor is between keyframes and planes alone. Those of places are made again with the places.
bool is_measured(const FactorData& data) {
  const auto all = blocks(data);
  return std::all_of(all.begin(), all.end(), [](const VariableId& variable) {
    return std::holds_alternative<KeyframeId>(variable) || std::holds_alternative<PlaneId>(variable);
  });
}

PlaneRecord record_of(const StoredMap& map, PlaneId id) {
  PlaneRecord record;
  record.id = id;
  const auto plane = map.planes.find(id);
  if (plane != map.planes.end()) {
    record.plane_class = plane->second.plane_class;
    record.last_covariance = plane->second.view_covariance;
  }
  const auto retired = map.retired.find(id);
  if (retired != map.retired.end()) record.retired = retired->second;
  return record;
}

void add_view(const StoredView& view, PlaneRecord& record) { record.observations.push_back({view.keyframe, view.factor, view.extent}); }

void sort_views(PlaneRecord& record) {
  std::stable_sort(record.observations.begin(), record.observations.end(),
                   [](const PlaneObservation& a, const PlaneObservation& b) { return a.keyframe < b.keyframe; });
}

}  // namespace

std::shared_ptr<const TakenMap> take_map(const std::string& path) {
  auto map = std::make_shared<TakenMap>();
  map->path = path;
  map->stored = read_map(path, Clouds::none);
  if (map->stored.keyframes.empty() || map->stored.sessions.empty()) throw StoreError(path + ": there is nothing in it yet");
  map->T_base_lidar = map->stored.sessions.begin()->second.T_base_lidar;
  GraphSnapshot snapshot = snapshot_of(map->stored);
  const auto clouds = std::make_shared<StoredClouds>(path);
  for (auto& [id, keyframe] : snapshot.keyframes) keyframe.cloud = KeyframeCloud(clouds, id);
  map->snapshot = std::make_shared<const GraphSnapshot>(std::move(snapshot));
  map->reference = std::make_shared<const ReferenceMap>(*map->snapshot, map->T_base_lidar);
  return map;
}

KeptMap kept_map(const TakenMap& map) {
  const StoredMap& stored = map.stored;
  GraphParts parts;
  parts.keyframes = stored.poses;
  for (const auto& [id, plane] : stored.planes) parts.planes[id] = plane.plane;
  for (const auto& [id, factor] : stored.factors) {
    if (is_measured(factor.data)) parts.factors[id] = factor;
  }
  for (auto [id, record] : stored.merges) {
    for (auto dropped = record.dropped.begin(); dropped != record.dropped.end();) {
      dropped = is_measured(dropped->second.data) ? std::next(dropped) : record.dropped.erase(dropped);
    }
    parts.merges[id] = std::move(record);
  }
  parts.next = stored.next_ids;
  KeptMap kept;
  try {
    kept.graph = graph_from_parts(std::move(parts));
  } catch (const std::runtime_error& error) {
    throw StoreError(map.path + ": the file is damaged (" + error.what() + ")");
  }
  kept.keyframes = map.snapshot->keyframes;
  std::optional<std::int64_t> session;
  for (const auto& [id, number] : stored.session_of) {
    if (session != number) kept.sessions.insert(id);
    session = number;
  }
  for (const auto& [id, plane] : stored.planes) kept.planes[id] = record_of(stored, id);
  for (const auto& [id, view] : stored.views) {
    const Factor* factor = kept.graph.find(id);
    if (factor == nullptr) continue;
    for (const VariableId& variable : blocks(factor->data)) {
      if (const auto* plane = std::get_if<PlaneId>(&variable)) add_view(view, kept.planes.at(*plane));
    }
  }
  for (const auto& [id, record] : kept.graph.merges()) {
    PlaneRecord& merged = kept.merged[id] = record_of(stored, id);
    const auto into = stored.planes.find(kept.graph.representative(id));
    if (into != stored.planes.end()) {
      merged.plane_class = into->second.plane_class;
      merged.last_covariance = into->second.view_covariance;
    }
    for (const FactorId factor : record.repointed) {
      const auto view = stored.views.find(factor);
      if (view != stored.views.end()) add_view(view->second, merged);
    }
    sort_views(merged);
  }
  for (auto& [id, record] : kept.planes) sort_views(record);
  return kept;
}

}  // namespace sgraph
