#include "sgraph_slam/core/odometry/map_updater.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sgraph {
namespace {

constexpr double degree = M_PI / 180;

double offset_of(int ring) { return ring % 4 == 0 ? 0.02 : ring % 4 == 2 ? -0.02 : 0.0; }  // [m]

// A box of 6 m by 5 m by 2.6 m, seen from a metre above its floor by a sensor whose beams err in range.
Cloud scan_from(const Eigen::Vector3d& sensor) {
  const Eigen::Vector3d low(-3, -2.5, 0), high(3, 2.5, 2.6);
  Cloud cloud;
  for (int column = 0; column < 720; ++column) {
    for (int ring = 0; ring < 16; ++ring) {
      const double azimuth = 2 * M_PI * column / 720;
      const double elevation = (-15 + 2 * ring) * degree;
      const Eigen::Vector3d ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      double range = 1e9;
      for (int axis = 0; axis < 3; ++axis) {
        const double wall = ray[axis] > 0 ? high[axis] : low[axis];
        if (std::abs(ray[axis]) > 1e-9) range = std::min(range, (wall - sensor[axis]) / ray[axis]);
      }
      Point point;
      point.set_position(((range + offset_of(ring)) * ray).cast<float>());
      point.ring = static_cast<std::uint16_t>(ring);
      cloud.points.push_back(point);
    }
  }
  return cloud;
}

RingCalibration calibration() {
  RingCalibration result;
  result.beams.resize(16);
  for (int ring = 0; ring < 16; ++ring) result.beams[static_cast<std::size_t>(ring)] = {offset_of(ring), 0.001, true, 0, 0, false};
  return result;
}

// Farthest that the map's surfaces lie off the wall at x = 3, where the sensor looks at it.
double worst(const MapUpdater& map) {
  double result = 0;
  int found = 0;
  for (double y = -1.75; y < 2; y += 0.5) {
    const Eigen::Vector3d p(3, y, 1.1);
    const Surface* surface = map.map().match(p, {0, 0, 1}, 0.1);
    if (surface == nullptr) continue;
    ++found;
    result = std::max(result, std::abs(surface->distance(p)));
  }
  EXPECT_GT(found, 4);
  return result;
}

TEST(MapUpdater, MapsAgainWithoutTheErrorsOfTheBeams) {
  OdometryParams params;
  MapUpdater map(params), never_asked(params);
  map.remember_scans(true);
  for (int i = 0; i < 6; ++i) {
    Pose pose;
    pose.translation = {0.1 * i, 0.05 * i, 1};
    map.insert(scan_from(pose.translation), pose, Placing::sure);
    never_asked.insert(scan_from(pose.translation), pose, Placing::sure);
  }
  EXPECT_GT(worst(map), 0.004);
  EXPECT_EQ(worst(map), worst(never_asked));
  map.correct(calibration());
  EXPECT_LT(worst(map), 0.001);
  never_asked.correct(calibration());  // keeps what it has
  EXPECT_GT(worst(never_asked), 0.004);
}

TEST(MapUpdater, ForgetsTheScansWhenTheyAreNotNeeded) {
  OdometryParams params;
  MapUpdater map(params);
  map.remember_scans(true);
  Pose pose;
  pose.translation = {0, 0, 1};
  map.insert(scan_from(pose.translation), pose, Placing::sure);
  map.remember_scans(false);
  const double before = worst(map);
  map.correct(calibration());
  EXPECT_EQ(worst(map), before);
}

}  // namespace
}  // namespace sgraph
