#include "sgraph_slam/core/odometry/map_updater.hpp"

#include <algorithm>

#include "sgraph_slam/core/odometry/thinning.hpp"
#include "sgraph_slam/core/registration/ring_image.hpp"
#include "sgraph_slam/core/registration/vertical.hpp"

namespace sgraph {
namespace {

constexpr double least_noise = 0.015;  // [m] of a residual: range noise and what the map doesn't know

}  // namespace

void insert_scan(SurfaceMap& map, const Cloud& deskewed, const Pose& T_map_lidar, double leaf, Placing placing) {
  const Eigen::Matrix3d rotation = T_map_lidar.matrix();
  const RingImage rings(deskewed);
  for (const Point& point : thinned(deskewed.points, leaf)) {
    std::optional<Eigen::Vector3f> normal = rings.normal(point);
    if (normal) normal = rotation.cast<float>() * *normal;
    map.insert(rotation * point.position().cast<double>() + T_map_lidar.translation, T_map_lidar.translation, normal, placing);
  }
  map.update();
}

void MapUpdater::find_vertical() {
  if (!vertical_) vertical_ = vertical_of(map_, up());
}

SurfaceMap MapUpdater::map_of(const Cloud& deskewed, const Pose& T_map_lidar) const {
  SurfaceMap map(params_);
  insert_scan(map, deskewed, T_map_lidar, leaf_, Placing::sure);
  return map;
}

double MapUpdater::noise() const { return std::max(least_noise, map_.noise()); }

}  // namespace sgraph
