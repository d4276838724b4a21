#include "sgraph_slam/core/planes/plane_map.hpp"

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

Outline moved(const Pose& T, const Outline& outline) {
  Outline result;
  result.reserve(outline.size());
  for (const auto& p : outline) result.push_back(T * p);
  return result;
}

// Covariance of a plane from the LiDAR's frame to the map's, the LiDAR's pose taken as known.
Eigen::Matrix3d moved_covariance(const Pose& T_map_lidar, const Plane& measured, const Plane& plane_map, const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix<double, 3, 2> turned = T_map_lidar.matrix() * tangent_basis(measured.normal);
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J.topLeftCorner<2, 2>() = tangent_basis(plane_map.normal).transpose() * turned;
  J.bottomLeftCorner<1, 2>() = -T_map_lidar.translation.transpose() * turned;
  return J * covariance * J.transpose();
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
  record.observations.push_back({keyframe, factor, moved(T_base_lidar, outline_lidar)});
  record.keyframes.insert(keyframe);
  record.last_seen = keyframe;
  record.last_covariance = moved_covariance(T_map_lidar, measured, *plane, covariance);
  const Outline seen = moved(T_map_lidar, outline_lidar);
  record.outline = grown_outline(*plane, record.outline, seen);
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

void PlaneMap::rebuild(const Graph& graph, PlaneRecord& record) const {
  const Plane* plane = graph.find(record.id);
  if (!plane) return;
  std::vector<Outline> outlines;
  std::vector<Eigen::Vector3d> corners;
  record.keyframes.clear();
  for (const PlaneObservation& seen : record.observations) {
    const Pose* T_map_base = graph.find(seen.keyframe);
    if (!T_map_base) continue;
    outlines.push_back(moved(*T_map_base, seen.outline_base));
    corners.insert(corners.end(), outlines.back().begin(), outlines.back().end());
    record.keyframes.insert(seen.keyframe);
  }
  if (!record.keyframes.empty()) record.last_seen = record.keyframes.newest();
  record.outline = convex_outline(*plane, corners);
  record.wall = make_wall(record.id, *plane, outlines, params_.tilt, params_.wall_gap);
  if (!record.wall) return;
  record.wall->last_seen = record.last_seen;
  record.wall->views = record.keyframes.size();
}

void PlaneMap::refresh(const Graph& graph, const DominantFrame& frame) {
  for (auto& [id, record] : records_) {
    rebuild(graph, record);
    reclassify(graph, id, frame);
  }
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
  if (to->second.last_seen < from->second.last_seen) to->second.last_covariance = from->second.last_covariance;
  retired_[merged] = from->second;
  records_.erase(from);
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
  retired_.erase(from);
  rebuild(graph, to->second);
  rebuild(graph, records_[merged]);
}

const PlaneRecord* PlaneMap::find(PlaneId id) const {
  const auto found = records_.find(id);
  return found == records_.end() ? nullptr : &found->second;
}

std::vector<Wall> PlaneMap::walls(std::size_t min_views, double min_height) const {
  std::vector<Wall> walls;
  for (const auto& [id, record] : records_) {
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
