#include "sgraph_slam/core/localisation/reference_map.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/search/layout_builder.hpp"
#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {
namespace {

constexpr double tilt = LayoutBuilder::tilt;
constexpr double floor_reach = 0.5;  // [m] beside what has been seen of a floor

Pose turn(const Eigen::Quaterniond& q) { return {q, Eigen::Vector3d::Zero()}; }

Layout map_layout(const GraphSnapshot& snapshot, const Eigen::Quaterniond& level, const Pose& T_base_lidar) {
  LayoutBuilder builder(level, T_base_lidar);
  for (const auto& [id, scene] : snapshot.planes) {
    std::vector<LayoutBuilder::View> views;
    for (const SceneObservation& seen : scene.observations) {
      const auto keyframe = snapshot.keyframes.find(seen.keyframe);
      if (keyframe != snapshot.keyframes.end()) views.push_back({keyframe->second.T_map_base, &seen.extent});
    }
    builder.add_plane(id, scene.plane, views);
  }
  return builder.build(LayoutBuilder::map_votes);
}

Eigen::Quaterniond map_level(const GraphSnapshot& snapshot) {
  Upward up;
  for (const auto& [id, scene] : snapshot.planes) up.add(scene.plane.normal, outline_area(scene.extent));
  return up.level();
}

// The floor that a keyframe's segments show below the LiDAR, as its height in the level frame at the point; the lowest large one.
struct SeenFloor {
  Eigen::Vector2d at;
  double height;
};

std::vector<SeenFloor> floors_of(const LocatedKeyframe& seen, const Pose& T_level_lidar) {
  std::vector<SeenFloor> floors;
  for (const PlaneSegment& segment : seen.segments.segments) {
    const Plane plane = T_level_lidar * segment.plane;
    const Eigen::Vector3d center = T_level_lidar * segment.centroid;
    if (plane.normal.z() < std::cos(tilt) || center.z() > T_level_lidar.translation.z()) continue;
    floors.push_back({center.head<2>(), center.z()});
  }
  return floors;
}

}  // namespace

ReferenceMap::ReferenceMap(const GraphSnapshot& snapshot, const Pose& T_base_lidar)
    : level_(map_level(snapshot)), search_(map_layout(snapshot, level_, T_base_lidar)) {
  for (const auto& [id, scene] : snapshot.planes) faces_.push_back({id, scene.plane, scene.covariance, scene.extent});
  for (const auto& [id, keyframe] : snapshot.keyframes) keyframes_.push_back(level_ * keyframe.T_map_base.translation);
  if (!snapshot.keyframes.empty()) first_pose_ = snapshot.keyframes.begin()->second.T_map_base;
}

double ReferenceMap::base_height(const Eigen::Vector2d& at_level) const {
  double least = HUGE_VAL;
  double height = 0;
  for (const Eigen::Vector3d& p : keyframes_) {
    const double distance = (p.head<2>() - at_level).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    height = p.z();
  }
  return height;
}

std::optional<double> ReferenceMap::floor_height(const Eigen::Vector2d& at_level, double near) const {
  std::optional<double> best;
  for (const Face& face : faces_) {
    const Plane plane = turn(level_) * face.plane;
    if (plane.normal.z() < std::cos(tilt)) continue;
    const Eigen::Vector3d foot(at_level.x(), at_level.y(), -(plane.d + plane.normal.head<2>().dot(at_level)) / plane.normal.z());
    if (best && std::abs(foot.z() - near) >= std::abs(*best - near)) continue;
    const Outline spot{foot, foot + Eigen::Vector3d(0.01, 0, 0), foot + Eigen::Vector3d(0, 0.01, 0)};
    if (outline_distance(plane, moved_outline(turn(level_), face.outline), spot) > floor_reach) continue;
    best = foot.z();
  }
  return best;
}

Surroundings surroundings_of(const std::vector<LocatedKeyframe>& keyframes, const Pose& T_base_lidar) {
  Upward up;
  for (const LocatedKeyframe& seen : keyframes) {
    const Pose T_odom_lidar = seen.keyframe.T_odom_base * T_base_lidar;
    for (const PlaneSegment& segment : seen.segments.segments) up.add(T_odom_lidar.rotation * segment.plane.normal, outline_area(segment.extent));
  }
  const Eigen::Quaterniond level = up.level();
  LayoutBuilder builder(level, T_base_lidar);
  for (const LocatedKeyframe& seen : keyframes) {
    for (const PlaneSegment& segment : seen.segments.segments) {
      if (segment.extent.size() >= 3 && segment.plane.normal.allFinite())
        builder.add_segment(segment.plane, segment.extent, seen.keyframe.T_odom_base);
    }
  }
  return {builder.build(LayoutBuilder::query_votes), level};
}

Pose pose_from_place(const ReferenceMap& map, const Surroundings& surroundings, const std::vector<LocatedKeyframe>& keyframes,
                     const Pose& T_base_lidar, const Pose2d& T_map_query) {
  std::vector<double> rises;
  const Eigen::Matrix2d R = T_map_query.matrix();
  for (const LocatedKeyframe& seen : keyframes) {
    const Pose T_level_base = turn(surroundings.level) * seen.keyframe.T_odom_base;
    const Eigen::Vector2d here = R * T_level_base.translation.head<2>() + T_map_query.translation;
    const double by_keyframe = map.base_height(here) - T_level_base.translation.z();
    std::size_t found = 0;
    for (const SeenFloor& floor : floors_of(seen, T_level_base * T_base_lidar)) {
      const auto height = map.floor_height(R * floor.at + T_map_query.translation, floor.height + by_keyframe);
      if (!height) continue;
      rises.push_back(*height - floor.height);
      ++found;
    }
    if (found == 0) rises.push_back(by_keyframe);
  }
  const double rise = rises.empty() ? 0 : quantile(rises, 0.5);
  const Pose T_level_level{Eigen::Quaterniond(Eigen::AngleAxisd(T_map_query.yaw, Eigen::Vector3d::UnitZ())),
                           {T_map_query.translation.x(), T_map_query.translation.y(), rise}};
  return turn(map.level().conjugate()) * T_level_level * turn(surroundings.level);
}

}  // namespace sgraph
