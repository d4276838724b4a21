#include "sgraph_slam/core/localisation/merge_maps.hpp"

#include <Eigen/LU>
#include <set>

#include "sgraph_slam/core/io/temporary_clouds.hpp"
#include "sgraph_slam/core/planes/retire_keyframes.hpp"
#include "sgraph_slam/core/store/map_recording.hpp"
#include "sgraph_slam/core/store/stored_clouds.hpp"

namespace sgraph {
namespace {

constexpr int enough = 100;  // inliers of a plane that a map kept: it was one

std::vector<KeyframeId> keyframes_of(const StoredMap& map, std::int64_t session) {
  std::vector<KeyframeId> ids;
  for (const auto& [id, keyframe] : map.keyframes) {
    if (map.session_of.at(id) == session) ids.push_back(id);
  }
  return ids;
}

// The keyframes to which motions of one source lead.
std::set<KeyframeId> reached_by(const StoredMap& map, Se3Between::Source source) {
  std::set<KeyframeId> reached;
  for (const auto& [id, factor] : map.factors) {
    const auto* between = std::get_if<Se3Between>(&factor.data);
    if (between != nullptr && between->source == source) reached.insert(between->to);
  }
  return reached;
}

// The motion between two keyframes as the map has it.
KeyframeMotion motion_of(const StoredMap& map, KeyframeId from, KeyframeId to, const FactorParams& params) {
  return {map.poses.at(from).inverse() * map.poses.at(to), retired_sigma(params).cwiseAbs2().asDiagonal()};
}

}  // namespace

std::vector<LocatedKeyframe> located_keyframes(const StoredMap& map, std::int64_t session) {
  std::map<KeyframeId, LocatedKeyframe> all;
  for (const KeyframeId id : keyframes_of(map, session)) all[id].keyframe = map.keyframes.at(id);
  if (all.empty()) return {};
  const Pose T_lidar_base = map.sessions.at(session).T_base_lidar.inverse();
  for (const auto& [id, view] : map.views) {
    const auto factor = map.factors.find(id);
    const auto* data = factor != map.factors.end() ? std::get_if<PosePlane>(&factor->second.data) : nullptr;
    const auto keyframe = all.find(view.keyframe);
    if (data == nullptr || keyframe == all.end() || view.extent.empty()) continue;
    PlaneSegment& segment = keyframe->second.segments.segments.emplace_back();
    segment.plane = data->measured;
    const Eigen::Matrix3d root = data->weight.matrix();
    segment.covariance = (root.transpose() * root).inverse();
    for (const auto& p : view.extent) segment.extent.push_back(T_lidar_base * p);
    for (const auto& p : segment.extent) segment.centroid += p / static_cast<double>(segment.extent.size());
    segment.count = enough;
  }
  const Pose T_own_map = all.begin()->second.keyframe.T_odom_base.inverse();
  std::vector<LocatedKeyframe> result;
  for (auto& [id, seen] : all) {
    seen.segments.stamp = seen.keyframe.stamp;
    seen.keyframe.id = {static_cast<std::int64_t>(result.size())};
    seen.keyframe.T_odom_base = T_own_map * seen.keyframe.T_odom_base;
    for (StampedPose& scan : seen.keyframe.scans) scan.pose = T_own_map * scan.pose;
    result.push_back(std::move(seen));
  }
  return result;
}

Localisation add_session(const StoredMap& from, std::int64_t session, const std::string& into, const std::string& out,
                         const std::optional<Pose>& near, const MappingParams& params) {
  const std::vector<LocatedKeyframe> keyframes = located_keyframes(from, session);
  const std::vector<KeyframeId> stored = keyframes_of(from, session);  // in the same order
  std::optional<StoredClouds> clouds;
  if (!from.path.empty()) clouds.emplace(from.path);
  // Keyframes that have handed over their views: the map knows better than the odometry where they stood.
  const std::set<KeyframeId> retired = reached_by(from, Se3Between::Source::retired);
  const std::set<KeyframeId> ridden = reached_by(from, Se3Between::Source::ride);
  const StoredSession& about = from.sessions.at(session);
  SessionStart start;
  if (!into.empty()) start = {take_map(into), MapMode::extend, near};
  MappingSession mapping(params, about.T_base_lidar, std::make_shared<TemporaryClouds>(), start);
  std::optional<MapRecording> recording;
  if (start.map) {
    recording.emplace(out, about, into, start.map->stored);
  } else {
    recording.emplace(out, about);
  }
  mapping.observe(&recording->observer());
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    Keyframe keyframe = keyframes[i].keyframe;
    if (!keyframe.cloud && clouds) keyframe.cloud = clouds->get(stored[i]);  // one at a time: a building's don't fit into memory
    if (i > 0 && (retired.count(stored[i]) > 0 || retired.count(stored[i - 1]) > 0))
      keyframe.measured = motion_of(from, stored[i - 1], stored[i], params.factors);
    if (i > 0 && ridden.count(stored[i]) > 0) keyframe.ride = unknown_rise;
    mapping.process(keyframe, keyframes[i].segments);
  }
  mapping.optimize();
  mapping.observe(nullptr);
  recording->finish();
  if (mapping.localisation()) return *mapping.localisation();
  Localisation first;
  first.result = LocalisationResult::found;
  first.reason = "it begins the map";
  return first;
}

}  // namespace sgraph
