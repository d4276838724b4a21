#include "sgraph_slam/core/sim/simulator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

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

TEST(Simulator, TheNoiseIsWhiteAndOfTheGivenSize) {
  const World world = box_world(8, 5);
  LidarSettings noisy;
  noisy.range_noise = 0.05;
  const SimulatedScans a = simulate_scans(world, 1, exact());
  const SimulatedScans b = simulate_scans(world, 1, noisy);
  ASSERT_EQ(a.scans[0]->size(), b.scans[0]->size());  // which echoes are lost doesn't depend on the range noise
  double mean = 0;
  double square = 0;
  double lagged = 0;
  double last = 0;
  const auto n = static_cast<double>(a.scans[0]->size());
  for (std::size_t i = 0; i < a.scans[0]->size(); ++i) {
    const double off = static_cast<double>(b.scans[0]->points[i].position().norm() - a.scans[0]->points[i].position().norm());
    mean += off / n;
    square += off * off / n;
    lagged += off * last / n;
    last = off;
  }
  EXPECT_NEAR(mean, 0, 0.001);
  EXPECT_NEAR(std::sqrt(square), 0.05, 0.001);
  EXPECT_NEAR(lagged / square, 0, 0.03);
}

TEST(Simulator, RangesComeInStepsOfTwoMillimetres) {
  const SimulatedScans scans = simulate_scans(box_world(8, 5), 1);
  for (const Point& p : scans.scans[0]->points) {
    const double steps = p.position().cast<double>().norm() / 0.002;
    EXPECT_NEAR(steps, std::round(steps), 0.01);
  }
}

TEST(Simulator, WithoutMotionDistortionAScanIsSeenFromItsStampAndCarriesNoTimes) {
  const World world = box_world(10, 6, 2.8, {{-3, 0}, {3, 0}});
  LidarSettings settings = exact();
  settings.motion_distortion = false;
  const SimulatedScans scans = simulate_scans(world, 1, settings, 60);
  const Pose T_world_lidar = scans.truth[0].pose * scans.T_base_lidar;
  for (const Point& p : scans.scans[0]->points) {
    const Eigen::Vector3d at = T_world_lidar * Eigen::Vector3d(p.position().cast<double>());
    EXPECT_LT(std::min({std::abs(5 - std::abs(at.x())), std::abs(3 - std::abs(at.y())), std::abs(at.z()), std::abs(2.8 - at.z())}), 0.003);
    EXPECT_EQ(p.time, 0.0F);
  }
}

// A long box: the floor far ahead is struck at grazing angles and lost, the end wall, nearly head on, is not.
TEST(Simulator, GrazingEchoesAreLost) {
  const SimulatedScans scans = simulate_scans(box_world(120, 4), 3, exact());
  std::array<int, 16> ahead{};
  for (const CloudPtr& cloud : scans.scans) {
    for (const Point& p : cloud->points) {
      if (std::abs(std::atan2(p.y, p.x)) < 1.5 * M_PI / 180) ++ahead[p.ring];
    }
  }
  // Of 45 echoes a ring: ring 7 (-1 degree) meets the floor at 40 m under 1 degree, ring 8 (+1) the end wall at 60 m, ring 0 the floor near by.
  EXPECT_GT(ahead[0], 40);
  EXPECT_GT(ahead[8], 30);
  EXPECT_LT(ahead[7], 8);
}

World with_glass(bool people) {
  return parse_world(std::string(R"(
walls:
  - {path: [[-4, -3], [10, -3], [10, 3], [-4, 3], [-4, -3]], thickness: 0.2}
  - {path: [[2, -3], [2, 3]], glass: true}
)") + (people ? "people: [{path: [[-2, 0]], speed: 0}]\n" : "") +
                     "lidar: {x: 0, y: 0, z: 0.3}\nroute: {waypoints: [[0, 0]]}\n");
}

TEST(Simulator, GlassReturnsHeadOnAndIsSeenThroughAslant) {
  const SimulatedScans scans = simulate_scans(with_glass(false), 5, exact());
  int pane_ahead = 0;
  int through_ahead = 0;
  int pane_aslant = 0;
  int through_aslant = 0;
  for (const CloudPtr& cloud : scans.scans) {
    for (const Point& p : cloud->points) {
      const double azimuth = std::abs(std::atan2(p.y, p.x)) * 180 / M_PI;
      if (p.x <= 0 || (p.ring != 7 && p.ring != 8)) continue;
      const bool pane = std::abs(p.x - 2) < 0.01;
      const bool through = p.x > 2.1;
      EXPECT_TRUE(pane || through || std::abs(std::abs(p.y) - 2.9) < 0.01 || p.z < -0.7);
      if (azimuth < 4) (pane ? pane_ahead : through_ahead) += 1;
      if (azimuth > 30 && azimuth < 50) (pane ? pane_aslant : through_aslant) += 1;
    }
  }
  EXPECT_GT(pane_ahead, 3 * through_ahead);
  EXPECT_GT(through_ahead, 0);
  EXPECT_LT(pane_aslant, through_aslant / 50);
  EXPECT_GT(through_aslant, 500);
}

TEST(Simulator, PeopleAreSeenWhereTheyStand) {
  const SimulatedScans without = simulate_scans(with_glass(false), 1, exact());
  const SimulatedScans with = simulate_scans(with_glass(true), 1, exact());
  int near_person = 0;
  for (const Point& p : with.scans[0]->points) {
    const double off = std::hypot(p.x + 2, p.y);
    if (off > 0.25) continue;
    ++near_person;
    EXPECT_LT(std::abs(p.z + 0.75 - 0.875), 0.9);
  }
  EXPECT_GT(near_person, 150);
  for (const Point& p : without.scans[0]->points) EXPECT_GT(std::hypot(p.x + 2, p.y), 0.25);
}

TEST(Simulator, TheSourceGivesAllEventsInOrderOfArrival) {
  SimulationSettings settings;
  settings.duration = 2.0;
  SimulatedSource source(box_world(8, 5), settings);
  EXPECT_EQ(source.scan_count(), 20);
  int scans = 0;
  int poses = 0;
  int inertial = 0;
  Stamp last;
  Stamp newest_pose;
  const Trajectory truth = source.ground_truth();
  while (const auto event = source.next()) {
    EXPECT_LE(last, source.last_arrival());
    last = source.last_arrival();
    if (const auto* cloud = std::get_if<CloudPtr>(&*event)) {
      EXPECT_EQ((*cloud)->stamp, truth[static_cast<std::size_t>(scans)].stamp);
      EXPECT_GT(newest_pose.after(0.021), (*cloud)->stamp);  // what belongs to a scan comes before it
      ++scans;
    } else if (const auto* pose = std::get_if<OdometrySample>(&*event)) {
      newest_pose = pose->stamp;
      ++poses;
    } else {
      ++inertial;
    }
  }
  EXPECT_EQ(scans, 20);
  EXPECT_EQ(poses, 101);
  EXPECT_EQ(inertial, 201);
}

TEST(Simulator, TruthTellsPlacesEnteredFromOthers) {
  const World world = parse_world(R"(
walls:
  - {path: [[0, 0], [10, 0], [10, 6], [0, 6], [0, 0]], thickness: 0.3}
  - [[5, 0], [5, 6]]
rooms: {left: [2, 3], right: [8, 3]}
route: {waypoints: [[2, 3], [3, 3]]}
)");
  const Motion motion(world.route, world.motion, 0);
  const nlohmann::json truth = nlohmann::json::parse(truth_json(world, motion, motion.duration()));
  ASSERT_EQ(truth["rooms"].size(), 1U);
  EXPECT_EQ(truth["rooms"][0]["id"], "left");
  ASSERT_EQ(truth["other_rooms"].size(), 1U);
  EXPECT_EQ(truth["other_rooms"][0]["id"], "right");
  EXPECT_EQ(truth["walls"].size(), 5U);
  EXPECT_NEAR(truth["walls"][0]["extend_p"].get<double>(), 0.15, 1e-9);
}

TEST(Simulator, StoreysLieOnTopOfEachOther) {
  const World world = parse_world(R"(
storeys:
  - {height: 2.5, walls: [[[-4, -3], [4, -3], [4, 3], [-4, 3], [-4, -3]]]}
  - {elevation: 2.8, height: 3.0, walls: [[[-5, -3], [5, -3], [5, 3], [-5, 3], [-5, -3]]]}
lidar: {x: 0, y: 0, z: 0.3}
route: {storey: 1, waypoints: [[0, 0]]}
)");
  const SimulatedScans scans = simulate_scans(world, 1, exact());
  EXPECT_NEAR(scans.truth[0].pose.translation.z(), 2.8 + 0.45, 1e-9);
  for (const Point& p : scans.scans[0]->points) {
    const double expected = box_distance(p.position().cast<double>().normalized(), {4.925, 2.925, 0}, 0.75, 3.0);
    EXPECT_NEAR(static_cast<double>(p.position().norm()), expected, 0.003);
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
