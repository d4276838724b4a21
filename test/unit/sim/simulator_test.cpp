#include "sgraph_slam/core/sim/simulator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sgraph::sim {
namespace {

bool same(const Cloud& a, const Cloud& b) {
  if (a.stamp != b.stamp || a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Point& p = a.points[i];
    const Point& q = b.points[i];
    if (p.x != q.x || p.y != q.y || p.z != q.z || p.intensity != q.intensity || p.time != q.time || p.ring != q.ring) return false;
  }
  return true;
}

LidarSettings exact() {
  LidarSettings settings;
  settings.range_noise = 0;
  return settings;
}

// Distance from the LiDAR to the inside of a box whose middle it stands in.
double box_distance(const Eigen::Vector3d& direction, const Eigen::Vector3d& half, double above_floor, double height) {
  double nearest = 1e9;
  for (int k = 0; k < 2; ++k) {
    if (direction[k] != 0) nearest = std::min(nearest, half[k] / std::abs(direction[k]));
  }
  if (direction.z() < 0) nearest = std::min(nearest, above_floor / -direction.z());
  if (direction.z() > 0) nearest = std::min(nearest, (height - above_floor) / direction.z());
  return nearest;
}

TEST(Simulator, RangesInABoxAreThoseOfTheClosedForm) {
  World world = box_world(8, 5, 3);
  world.T_base_lidar.translation = {0, 0, 0.3};
  const SimulatedScans scans = simulate_scans(world, 2, exact());
  ASSERT_EQ(scans.scans.size(), 2U);
  for (const CloudPtr& cloud : scans.scans) {
    ASSERT_GT(cloud->size(), 28000U);
    for (const Point& p : cloud->points) {
      const Eigen::Vector3d at = p.position().cast<double>();
      const double expected = box_distance(at.normalized(), {4, 2.5, 0}, 0.75, 3);
      // Half a step of the range, and half a step of the azimuth on a wall that the ray strikes aslant.
      EXPECT_NEAR(at.norm(), expected, 0.0011 + 0.00009 * expected * 4);
    }
  }
}

TEST(Simulator, DeskewedWithTheTruthAMovingScanLiesOnTheBox) {
  const World world = box_world(10, 6, 2.8, {{-3, -1}, {3, -1}, {3, 1.5}, {-3, 1}});
  LidarSettings settings = exact();
  for (const StampConvention stamp : {StampConvention::first, StampConvention::last}) {
    settings.stamp = stamp;
    SimulationSettings simulation;
    simulation.lidar = settings;
    const SimulatedSource source(world, simulation);
    double worst = 0;
    for (const int number : {45, 80, 95, 120, 150}) {
      const Cloud cloud = source.lidar().scan(number);
      for (const Point& p : cloud.points) {
        const double time = source.lidar().time_of(number) + static_cast<double>(p.time);
        const Eigen::Vector3d at = source.motion().pose_at(time) * (world.T_base_lidar * Eigen::Vector3d(p.position().cast<double>()));
        const double off = std::min({std::abs(5 - std::abs(at.x())), std::abs(3 - std::abs(at.y())), std::abs(at.z()), std::abs(2.8 - at.z())});
        worst = std::max(worst, off);
      }
    }
    EXPECT_LT(worst, 0.003);
    EXPECT_GT(worst, 1e-5);
  }
}

// velodyne_pointcloud: point time = 55.296 us a firing + 2.304 us a laser; lasers fire at -15, 1, -13, 3, ... 15 degrees; azimuth grows clockwise
// with the time within the revolution. The time alone thus tells ring and direction of a point.
TEST(Simulator, FiringOrderAndTimesAreTheDrivers) {
  LidarSettings settings = exact();
  for (const StampConvention stamp : {StampConvention::first, StampConvention::last}) {
    settings.stamp = stamp;
    const SimulatedScans scans = simulate_scans(box_world(8, 5), 3, settings);
    for (std::size_t k = 0; k < scans.scans.size(); ++k) {
      const Cloud& cloud = *scans.scans[k];
      double last = -1;
      double lowest = 1;
      double highest = -1;
      for (const Point& p : cloud.points) {
        const double since_start = static_cast<double>(cloud.stamp.nanoseconds - settings.start) * 1e-9 + static_cast<double>(p.time);
        const double firings = since_start / 55.296e-6;
        const double laser = (firings - std::floor(firings + 0.01)) * 24;
        const auto n = static_cast<int>(std::lround(laser));
        ASSERT_NEAR(laser, n, 0.02);
        ASSERT_LT(n, 16);
        const double elevation = n % 2 == 0 ? -15 + n : n;
        EXPECT_EQ(p.ring, std::lround((elevation + 15) / 2));
        EXPECT_NEAR(std::atan2(p.z, std::hypot(p.x, p.y)) * 180 / M_PI, elevation, 1e-3);
        const double azimuth = -std::atan2(p.y, p.x) * 180 / M_PI;
        EXPECT_LT(std::abs(std::remainder(azimuth - since_start * 3600, 360.0)), 0.006);
        EXPECT_GT(p.time, last);
        last = static_cast<double>(p.time);
        lowest = std::min(lowest, last);
        highest = std::max(highest, last);
      }
      EXPECT_NEAR(highest - lowest, 0.1, 1e-3);
      EXPECT_NEAR(stamp == StampConvention::first ? lowest : highest, 0, 2e-4);
    }
  }
}

TEST(Simulator, TheStampConventionChangesOnlyStampsAndTimes) {
  LidarSettings settings;
  const World world = box_world(8, 5, 2.8, {{-2, 0}, {2, 0}});
  settings.stamp = StampConvention::first;
  const SimulatedScans first = simulate_scans(world, 1, settings, 45);
  settings.stamp = StampConvention::last;
  const SimulatedScans last = simulate_scans(world, 1, settings, 45);
  const double apart = last.scans[0]->stamp - first.scans[0]->stamp;
  EXPECT_NEAR(apart, 0.1, 1e-4);
  ASSERT_EQ(first.scans[0]->size(), last.scans[0]->size());
  for (std::size_t i = 0; i < first.scans[0]->size(); ++i) {
    const Point& a = first.scans[0]->points[i];
    const Point& b = last.scans[0]->points[i];
    EXPECT_EQ(a.x, b.x);
    EXPECT_NEAR(static_cast<double>(a.time) - static_cast<double>(b.time), apart, 1e-7);
  }
  EXPECT_GT((last.truth[0].pose.translation - first.truth[0].pose.translation).norm(), 0.02);
}

TEST(Simulator, SameSeedSameScansOtherSeedOthers) {
  const World world = box_world(8, 5);
  LidarSettings settings;
  const SimulatedScans a = simulate_scans(world, 2, settings);
  const SimulatedScans b = simulate_scans(world, 2, settings);
  settings.seed = 2;
  const SimulatedScans c = simulate_scans(world, 2, settings);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_TRUE(same(*a.scans[i], *b.scans[i]));
    EXPECT_FALSE(same(*a.scans[i], *c.scans[i]));
  }
}

TEST(Simulator, ShippedWorldsAreAccepted) {
  for (const char* name : {"demo", "se1", "se2", "cf1", "cf2", "lc1", "le1", "le2", "oblique", "two_wings", "people", "fast_walker"}) {
    const World world = read_world(std::string("worlds/") + name + ".yaml");
    EXPECT_EQ(world.name, name);
    EXPECT_FALSE(world.storeys.front().corridors.empty());
  }
}

}  // namespace
}  // namespace sgraph::sim
