#include "sgraph_slam/core/planes/drop_planes.hpp"

#include <cmath>
#include <map>
#include <utility>

#include "sgraph_slam/core/planes/passages.hpp"

namespace sgraph {
namespace {

constexpr std::size_t known_better = 5;  // times as many views
constexpr std::size_t few_views = 5;     // of a plane that the robot walked through: with more it is a wall with a passage
constexpr double leaning = 0.026;        // [rad] of a plane against the wall that it lies at

// Whether a plane lies beside one that is known much better, in front of it or within it: what segmentation made of a wall and something before it,
// of a wall through a pane, of a person at a wall. Seen more than rarely it may be a wall's thicker part, but not when it leans against the wall.
bool is_ghost(const Graph& graph, const PlaneLayer& planes, const PlaneRecord& record, bool rarely_seen) {
  const AssociationParams& params = planes.params.association;
  const Plane& plane = *graph.find(record.id);
  const Eigen::Vector3d center = outline_center(record.outline);
  // A wall that reaches behind all of the plane is no further off than this, however the two lean.
  const double gap = params.ghost_distance + std::sin(params.max_angle) * record.box().diagonal().norm() + PlaneMap::stale;
  for (const PlaneId id : planes.map.index().near(record.box(), gap)) {
    const PlaneRecord& other = *planes.map.find(id);
    if (other.storey != record.storey) continue;
    if (other.keyframes.size() < known_better * record.keyframes.size()) continue;
    const Plane& wall = *graph.find(id);
    const double cosine = wall.normal.dot(plane.normal);
    if (cosine < std::cos(params.max_angle) || std::abs(wall.distance(center)) > params.ghost_distance) continue;
    if (!rarely_seen && cosine > std::cos(leaning)) continue;
    if (outline_distance(wall, other.outline, record.outline) == 0) return true;
  }
  return false;
}

// The robot's paths since a session, storey by storey, made when they are asked for.
class Paths {
 public:
  Paths(const Graph& graph, const PlaneLayer& planes) : graph_(graph), planes_(planes) {}

  // Where the robot has walked since the session in which the plane was first seen. Through a door that was shut since then, or where a wall was
  // built, it could walk in the sessions before.
  const GroundPath& since_seen(const PlaneRecord& record) {
    const KeyframeId since = planes_.session_of(*record.keyframes.begin());
    const auto known = paths_.find({record.storey, since});
    if (known != paths_.end()) return known->second;
    return paths_.emplace(std::pair{record.storey, since}, path_on(graph_, planes_, record.storey, since)).first->second;
  }

 private:
  const Graph& graph_;
  const PlaneLayer& planes_;
  std::map<std::pair<int, KeyframeId>, GroundPath> paths_;
};

// Whether the plane was seen only where the robot has walked.
bool is_walked_through(const PlaneRecord& record, Paths& paths) {
  if (!record.wall || record.keyframes.empty()) return false;
  Wall wall = *record.wall;
  open_passages(wall, paths.since_seen(record));
  return wall.support.empty();
}

}  // namespace

int drop_passing_planes(Committer& committer, PlaneLayer& planes, bool all) {
  const AssociationParams& params = planes.params.association;
  Paths paths(committer.graph, planes);
  Transaction edit;
  edit.reason = "planes seen in passing";
  std::vector<PlaneId> passing;
  for (const auto& [id, record] : planes.map.records()) {
    if (record.keyframes.size() <= few_views && is_walked_through(record, paths)) {
      edit.remove_variables.emplace_back(id);
      passing.push_back(id);
      committer.note(false, "plane/" + std::to_string(id.value), "dropped: the robot has walked through it");
      continue;
    }
    const auto unseen = committer.newest().value - record.last_seen.value;
    const bool rarely_seen = record.keyframes.size() <= static_cast<std::size_t>(params.drop_views);
    const bool small_and_old = rarely_seen && unseen >= params.drop_after && outline_area(record.outline) < params.drop_area;
    if (!small_and_old && (!(all || unseen >= params.drop_ghost_after) || !is_ghost(committer.graph, planes, record, rarely_seen))) continue;
    edit.remove_variables.emplace_back(id);
    passing.push_back(id);
  }
  if (passing.empty() || !committer.commit(edit).ok()) return 0;
  for (const PlaneId id : passing) planes.map.erase(id);
  return static_cast<int>(passing.size());
}

}  // namespace sgraph
