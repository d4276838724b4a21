#include "sgraph_slam/core/odometry/map_updater.hpp"

#include <algorithm>

#include "sgraph_slam/core/math/noise.hpp"
#include "sgraph_slam/core/odometry/thinning.hpp"
#include "sgraph_slam/core/registration/ring_image.hpp"
#include "sgraph_slam/core/registration/vertical.hpp"

namespace sgraph {
namespace {

constexpr int look_every = 20;  // scans, for floors and ceilings that are new

// Hands `take` one of the scan's points in a voxel of `leaf` [m] in the map's frame, with the normal that the scan shows.
template <typename Take>
void visit_points(const Cloud& deskewed, const Pose& T_map_lidar, double leaf, Take&& take) {
  const Eigen::Matrix3d rotation = T_map_lidar.matrix();
  const RingImage rings(deskewed);
  for (const Point& point : thinned(deskewed.points, leaf)) {
    std::optional<Eigen::Vector3f> normal = rings.normal(point);
    if (normal) normal = rotation.cast<float>() * *normal;
    take(rotation * point.position().cast<double>() + T_map_lidar.translation, normal);
  }
}

}  // namespace

void MapUpdater::insert(const Cloud& deskewed, const Pose& T_odom_lidar, Placing placing) {
  const Eigen::Vector3d& sensor = T_odom_lidar.translation;
  const double range_noise = noise();
  visit_points(deskewed, T_odom_lidar, leaf_, [&](const Eigen::Vector3d& p, const std::optional<Eigen::Vector3f>& normal) {
    map_.insert(level_.settle(p, sensor, range_noise), sensor, normal, placing);
  });
  map_.update();
  level_.update();
  if (vertical_ && inserted_++ % look_every == 0) {
    level_.find(map_.surfaces(looked_from_), *vertical_);
    looked_from_ = looked_at_;
    looked_at_ = map_.surface_voxels();
  }
}

void MapUpdater::clear() {
  map_ = SurfaceMap(params_);
  level_ = LevelPlanes();
  inserted_ = 0;
  looked_at_ = looked_from_ = 0;
}

void MapUpdater::find_vertical() {
  if (!vertical_) vertical_ = vertical_of(map_, up());
}

SurfaceMap MapUpdater::map_of(const Cloud& deskewed, const Pose& T_map_lidar) const {
  SurfaceMap map(params_);
  visit_points(deskewed, T_map_lidar, leaf_, [&](const Eigen::Vector3d& p, const std::optional<Eigen::Vector3f>& normal) {
    map.insert(p, T_map_lidar.translation, normal, Placing::sure);
  });
  map.update();
  return map;
}

double MapUpdater::noise() const { return std::max(noise::mapped_surface, map_.noise()); }

}  // namespace sgraph
