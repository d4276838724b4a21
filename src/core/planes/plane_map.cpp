#include "sgraph_slam/core/planes/plane_map.hpp"

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/planes/moved_covariance.hpp"

namespace sgraph {
namespace {

// Views in the order of their keyframes.
struct ByKeyframe {
  bool operator()(const PlaneObservation& a, KeyframeId b) const { return a.keyframe < b; }
  bool operator()(KeyframeId a, const PlaneObservation& b) const { return a < b.keyframe; }
};

// Whether two poses of a keyframe put what it saw in places further apart than the tolerance.
bool has_moved(const Pose& before, const Pose& now) {
  constexpr double reach = 20;  // of what is seen [m]
  const double angle = 2 * (before.rotation.conjugate() * now.rotation).vec().norm();
  return (before.translation - now.translation).norm() + reach * angle > PlaneMap::tolerance;
}

bool has_moved(const PlaneRecord& record, const Plane& now) {
  return std::any_of(record.outline.begin(), record.outline.end(), [&](const Eigen::Vector3d& corner) {
    return std::abs(record.built.distance(corner) - now.distance(corner)) > PlaneMap::tolerance;
  });
}

double middle_height(const Outline& outline) {
  const auto lower = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.z() < b.z(); };
  const auto [low, high] = std::minmax_element(outline.begin(), outline.end(), lower);
  return outline.empty() ? 0 : 0.5 * (low->z() + high->z());
}

PlaneClassParams class_params(const SemanticsParams& params) { return {params.tilt, params.oblique, params.hysteresis}; }

}  // namespace

void PlaneMap::observe(const Graph& graph, PlaneId id, KeyframeId keyframe, FactorId factor, const Outline& outline_lidar, const Pose& T_base_lidar,
                       const Plane& measured, const Eigen::Matrix3d& covariance) {
  const Plane* plane = graph.find(id);
  const Pose* T_map_base = graph.find(keyframe);
  if (!plane || !T_map_base) return;
  const Pose T_map_lidar = *T_map_base * T_base_lidar;
  PlaneRecord& record = records_[id];
  record.id = id;
  record.observations.push_back({keyframe, factor, moved_outline(T_base_lidar, outline_lidar)});
  record.keyframes.insert(keyframe);
  record.last_seen = keyframe;
  record.last_covariance = moved_covariance(T_map_lidar, measured, *plane, covariance);
  record.grown = true;
  poses_.emplace(keyframe, *T_map_base);
  const Outline seen = moved_outline(T_map_lidar, outline_lidar);
  record.outline = grown_outline(*plane, record.outline, seen);
  index_.put(id, record.box());
  const auto whole = make_wall(id, *plane, {record.outline}, params_.tilt, params_.wall_gap);
  const auto piece = make_wall(id, *plane, {seen}, params_.tilt, params_.wall_gap);
  if (!whole || !piece) {
    record.wall.reset();
    return;
  }
  Intervals support = record.wall ? record.wall->support : Intervals{};
  support.insert(support.end(), piece->support.begin(), piece->support.end());
  record.wall = whole;
  record.wall->support = unite(std::move(support), params_.wall_gap);
  record.wall->last_seen = keyframe;
  record.wall->views = record.keyframes.size();
}

std::pair<PlaneRecord::Views, PlaneRecord::Views> PlaneRecord::views_of(KeyframeId keyframe) const {
  return std::equal_range(observations.begin(), observations.end(), keyframe, ByKeyframe{});
}

Eigen::AlignedBox3d PlaneRecord::box() const {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& corner : outline) box.extend(corner);
  return box;
}

void PlaneMap::rebuild(const Graph& graph, PlaneRecord& record) {
  const Plane* plane = graph.find(record.id);
  if (!plane) return;
  std::vector<Outline> outlines;
  std::vector<Eigen::Vector3d> corners;
  record.keyframes = record.retired;
  for (const PlaneObservation& seen : record.observations) {
    const Pose* T_map_base = graph.find(seen.keyframe);
    if (!T_map_base) continue;
    outlines.push_back(moved_outline(*T_map_base, seen.outline_base));
    corners.insert(corners.end(), outlines.back().begin(), outlines.back().end());
    record.keyframes.insert(seen.keyframe);
  }
  if (!record.keyframes.empty()) record.last_seen = std::max(record.last_seen, record.keyframes.newest());
  record.outline = convex_outline(*plane, corners);
  record.built = *plane;
  record.middle = middle_height(corners);
  record.grown = false;
  index_.put(record.id, record.box());
  record.wall = make_wall(record.id, *plane, outlines, params_.tilt, params_.wall_gap);
  if (!record.wall) return;
  record.wall->last_seen = record.last_seen;
  record.wall->views = record.keyframes.size();
}

// The wall of a plane that moved a little. False when it takes more than that.
bool PlaneMap::follow(const Plane& plane, PlaneRecord& record) const {
  const double level = plane.normal.head<2>().norm();
  if ((level >= std::cos(params_.tilt)) != record.wall.has_value()) return false;
  if (!record.wall) return true;
  Wall& wall = *record.wall;
  const Eigen::Vector2d foot = -wall.offset * wall.normal;
  const Eigen::Vector2d before = wall.direction();
  wall.normal = plane.normal.head<2>() / level;
  wall.offset = (plane.d + plane.normal.z() * record.middle) / level;
  // Positions along the wall are from the foot of the map's origin, which turns with it.
  const double scale = before.dot(wall.direction());
  const double shift = foot.dot(wall.direction());
  for (Interval& stretch : wall.support) stretch = {scale * stretch.low + shift, scale * stretch.high + shift};
  return true;
}

std::vector<KeyframeId> PlaneMap::moved_keyframes(const Graph& graph) {
  std::vector<KeyframeId> ids;
  for (auto known = poses_.begin(); known != poses_.end();) {
    const Pose* now = graph.find(known->first);
    if (now && !has_moved(known->second, *now)) {
      ++known;
      continue;
    }
    ids.push_back(known->first);
    if (now) known->second = *now;
    known = now ? std::next(known) : poses_.erase(known);
  }
  return ids;
}

void PlaneMap::refresh(const Graph& graph, const DominantFrame& frame) {
  const std::vector<KeyframeId> moved = moved_keyframes(graph);
  const auto saw_from_elsewhere = [&moved](const PlaneRecord& record) {
    return std::any_of(moved.begin(), moved.end(), [&](KeyframeId id) { return record.keyframes.count(id) > 0; });
  };
  for (auto& [id, record] : records_) {
    const Plane* plane = graph.find(id);
    if (!plane) continue;
    if (record.grown || has_moved(record, *plane) || saw_from_elsewhere(record) || !follow(*plane, record)) rebuild(graph, record);
    reclassify(graph, id, frame);
  }
}

void PlaneMap::erase(PlaneId id) {
  records_.erase(id);
  index_.erase(id);
}

void PlaneMap::reclassify(const Graph& graph, PlaneId id, const DominantFrame& frame) {
  const auto record = records_.find(id);
  const Plane* plane = graph.find(id);
  if (record == records_.end() || !plane) return;
  record->second.plane_class = classify(plane->normal, frame, record->second.plane_class, class_params(params_));
}

void PlaneMap::merge(const Graph& graph, PlaneId kept, PlaneId merged) {
  const auto from = records_.find(merged);
  const auto to = records_.find(kept);
  if (from == records_.end() || to == records_.end() || from == to) return;
  auto& observations = to->second.observations;
  observations.insert(observations.end(), from->second.observations.begin(), from->second.observations.end());
  std::stable_sort(observations.begin(), observations.end(), [](const auto& a, const auto& b) { return a.keyframe < b.keyframe; });
  for (const KeyframeId id : from->second.retired) to->second.retired.insert(id);
  if (to->second.last_seen < from->second.last_seen) to->second.last_covariance = from->second.last_covariance;
  retired_[merged] = from->second;
  erase(merged);
  rebuild(graph, to->second);
}

void PlaneMap::undo_merge(const Graph& graph, PlaneId kept, PlaneId merged) {
  const auto from = retired_.find(merged);
  const auto to = records_.find(kept);
  if (from == retired_.end() || to == records_.end()) return;
  std::set<FactorId> own;
  for (const auto& seen : from->second.observations) own.insert(seen.factor);
  auto& observations = to->second.observations;
  observations.erase(std::remove_if(observations.begin(), observations.end(), [&](const auto& seen) { return own.count(seen.factor) > 0; }),
                     observations.end());
  records_[merged] = from->second;
  auto& restored = records_[merged].observations;
  restored.erase(std::remove_if(restored.begin(), restored.end(), [&graph](const auto& seen) { return graph.find(seen.factor) == nullptr; }),
                 restored.end());
  retired_.erase(from);
  rebuild(graph, to->second);
  rebuild(graph, records_[merged]);
}

void PlaneMap::restore(const Graph& graph, std::map<PlaneId, PlaneRecord> records, std::map<PlaneId, PlaneRecord> retired) {
  records_ = std::move(records);
  retired_ = std::move(retired);
  for (auto& [id, record] : records_) rebuild(graph, record);
}

const PlaneRecord* PlaneMap::find(PlaneId id) const {
  const auto found = records_.find(id);
  return found == records_.end() ? nullptr : &found->second;
}

void PlaneMap::retire(const Graph& graph, KeyframeId id, KeyframeId to, const std::map<FactorId, FactorId>& moved_views) {
  const Pose T_to_id = graph.find(to)->inverse() * *graph.find(id);
  for (auto& [plane, record] : records_) {
    if (record.keyframes.count(id) == 0) continue;
    auto& all = record.observations;
    const auto [first, last] = std::equal_range(all.begin(), all.end(), id, ByKeyframe{});
    std::vector<PlaneObservation> kept;
    for (auto seen = first; seen != last; ++seen) {
      const auto now = moved_views.find(seen->factor);
      if (now != moved_views.end()) kept.push_back({to, now->second, moved_outline(T_to_id, seen->outline_base)});
    }
    all.erase(first, last);
    record.retired.insert(id);
    all.insert(std::upper_bound(all.begin(), all.end(), to, ByKeyframe{}), kept.begin(), kept.end());
    record.grown = true;
  }
}

void PlaneMap::set_storey(PlaneId id, int storey) {
  const auto record = records_.find(id);
  if (record != records_.end()) record->second.storey = storey;
}

std::vector<Wall> PlaneMap::walls(std::size_t min_views, double min_height, std::optional<int> storey) const {
  std::vector<Wall> walls;
  for (const auto& [id, record] : records_) {
    if (storey && record.storey != *storey) continue;
    if (record.wall && record.keyframes.size() >= min_views && record.wall->height >= min_height) walls.push_back(*record.wall);
  }
  return walls;
}

std::vector<WallDirection> wall_directions(const PlaneMap& planes) {
  std::vector<WallDirection> directions;
  for (const auto& [id, record] : planes.records()) {
    if (record.wall) directions.push_back({std::atan2(record.wall->normal.y(), record.wall->normal.x()), total_length(record.wall->support)});
  }
  return directions;
}

}  // namespace sgraph
