#include "sgraph_slam/core/odometry/map_updater.hpp"

#include <algorithm>

#include "sgraph_slam/core/math/noise.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/odometry/thinning.hpp"
#include "sgraph_slam/core/registration/ring_image.hpp"
#include "sgraph_slam/core/registration/vertical.hpp"

namespace sgraph {
namespace {

constexpr int look_every = 20;  // scans, for floors and ceilings that are new

// A scan that is kept shows something new: the robot has moved so far since the last one.
constexpr double step = 0.05;    // [m]
constexpr double turned = 0.05;  // [rad]

}  // namespace

// One of the scan's points in a voxel of `leaf_` [m], with the normals that the scan shows.
MapUpdater::Taken MapUpdater::taken_from(const Cloud& deskewed, const Pose& T_odom_lidar, Placing placing) const {
  const RingImage rings(deskewed);
  Taken scan{thinned(deskewed.points, leaf_), {}, T_odom_lidar, placing};
  scan.normals.reserve(scan.points.size());
  for (const Point& point : scan.points) scan.normals.push_back(rings.normal(point));
  return scan;
}

void MapUpdater::insert(const Cloud& deskewed, const Pose& T_odom_lidar, Placing placing) {
  Taken scan = taken_from(deskewed, T_odom_lidar, placing);
  insert(scan);
  if (remembers_ && shows_more(T_odom_lidar)) kept_.push_back(std::move(scan));
}

bool MapUpdater::shows_more(const Pose& T_odom_lidar) const {
  if (kept_.empty()) return true;
  const Pose& last = kept_.back().T_odom_lidar;
  return (last.translation - T_odom_lidar.translation).norm() > step || rotation_angle(last.rotation, T_odom_lidar.rotation) > turned;
}

void MapUpdater::insert(const Taken& scan) {
  const Eigen::Vector3d& sensor = scan.T_odom_lidar.translation;
  const Eigen::Matrix3d rotation = scan.T_odom_lidar.matrix();
  const double range_noise = noise();
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    std::optional<Eigen::Vector3f> normal = scan.normals[i];
    if (normal) normal = rotation.cast<float>() * *normal;
    const Eigen::Vector3d p = rotation * scan.points[i].position().cast<double>() + sensor;
    map_.insert(level_.settle(p, sensor, range_noise), sensor, normal, scan.placing);
  }
  map_.update();
  level_.update();
  if (vertical_ && inserted_++ % look_every == 0) {
    level_.find(map_.surfaces(looked_from_), *vertical_);
    looked_from_ = looked_at_;
    looked_at_ = map_.surface_voxels();
  }
}

void MapUpdater::remember_scans(bool remember) {
  remembers_ = remember;
  if (!remember) kept_ = {};
}

void MapUpdater::correct(const RingCalibration& added) {
  std::vector<Taken> scans;
  scans.swap(kept_);
  if (scans.empty()) return;
  clear();
  for (Taken& scan : scans) {
    added.correct(scan.points);
    insert(scan);
  }
  scans.swap(kept_);
}

void MapUpdater::clear() {
  map_ = SurfaceMap(params_);
  kept_.clear();
  level_ = LevelPlanes();
  inserted_ = 0;
  looked_at_ = looked_from_ = 0;
}

void MapUpdater::find_vertical() {
  if (!vertical_) vertical_ = vertical_of(map_, up());
}

SurfaceMap MapUpdater::map_of(const Cloud& deskewed, const Pose& T_map_lidar) const {
  SurfaceMap map(params_);
  const Taken scan = taken_from(deskewed, T_map_lidar, Placing::sure);
  const Eigen::Matrix3d rotation = T_map_lidar.matrix();
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    std::optional<Eigen::Vector3f> normal = scan.normals[i];
    if (normal) normal = rotation.cast<float>() * *normal;
    map.insert(rotation * scan.points[i].position().cast<double>() + T_map_lidar.translation, T_map_lidar.translation, normal, scan.placing);
  }
  map.update();
  return map;
}

double MapUpdater::noise() const { return std::max(noise::mapped_surface, map_.noise()); }

}  // namespace sgraph
