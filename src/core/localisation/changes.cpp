#include "sgraph_slam/core/localisation/changes.hpp"

#include <algorithm>

#include "sgraph_slam/core/localisation/reference_map.hpp"

namespace sgraph {
namespace {

constexpr double same_face = 0.15;  // across [m]: what two views of one face are apart
constexpr double parallel = 0.97;   // cosine of 14 degrees
constexpr double shortest = 0.5;    // [m]

// Faces of one layout in the free space of the other, where that has no such face.
std::vector<WallSample> contradicting(const Layout& faces, const Layout& space) {
  const WallIndex index(space);
  std::vector<WallSample> samples;
  for (const WallSample& s : faces.samples()) {
    if (s.solid && space.is_free(s.point) && !index.nearest(s.point, s.normal, same_face, parallel)) samples.push_back(s);
  }
  return samples;
}

void add_pieces(const std::vector<WallSample>& samples, bool appeared, std::vector<MapChange>& changes) {
  for (const auto& piece : joined_pieces(samples)) {
    MapChange change{appeared, Eigen::Vector2d::Zero(), WallSample::spacing * static_cast<double>(piece.size())};
    for (const std::size_t i : piece) change.center += samples[i].point / static_cast<double>(piece.size());
    if (change.length >= shortest) changes.push_back(change);
  }
}

}  // namespace

std::vector<MapChange> changes_of(const StoredMap& map, std::int64_t session) {
  const GraphSnapshot snapshot = snapshot_of(map);
  const Pose T_base_lidar = map.sessions.begin()->second.T_base_lidar;
  const Layout before = layout_of(snapshot, T_base_lidar, [&](KeyframeId id) { return map.session_of.at(id) < session; });
  const Layout now = layout_of(snapshot, T_base_lidar, [&](KeyframeId id) { return map.session_of.at(id) == session; });
  std::vector<MapChange> changes;
  add_pieces(contradicting(now, before), true, changes);
  add_pieces(contradicting(before, now), false, changes);
  std::stable_sort(changes.begin(), changes.end(), [](const MapChange& a, const MapChange& b) { return a.length > b.length; });
  return changes;
}

}  // namespace sgraph
