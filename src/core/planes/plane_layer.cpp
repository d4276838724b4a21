#include "sgraph_slam/core/planes/plane_layer.hpp"

namespace sgraph {

void set_storeys(PlaneLayer& planes, std::map<KeyframeId, int> storeys) {
  planes.storeys = std::move(storeys);
  std::vector<std::pair<PlaneId, int>> moved;
  for (const auto& [id, record] : planes.map.records()) {
    std::map<int, std::size_t> views;
    for (const PlaneObservation& seen : record.observations) ++views[planes.storey_of(seen.keyframe)];
    auto most = views.begin();
    for (auto storey = views.begin(); storey != views.end(); ++storey) {
      if (storey->second > most->second) most = storey;
    }
    if (most != views.end() && most->first != record.storey) moved.emplace_back(id, most->first);
  }
  for (const auto& [id, storey] : moved) planes.map.set_storey(id, storey);
}

GroundPath path_on(const Graph& graph, const PlaneLayer& planes, int storey, KeyframeId since) {
  std::vector<std::vector<Eigen::Vector2d>> stretches(1);
  for (auto keyframe = graph.keyframes().lower_bound(since); keyframe != graph.keyframes().end(); ++keyframe) {
    const auto& [id, T_map_base] = *keyframe;
    if (planes.sessions.count(id) > 0 && !stretches.back().empty()) stretches.emplace_back();
    if (planes.storey_of(id) == storey) {
      stretches.back().emplace_back(T_map_base.translation.head<2>());
    } else if (!stretches.back().empty()) {
      stretches.emplace_back();
    }
  }
  return GroundPath(stretches);
}

}  // namespace sgraph
