#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "sgraph_slam/core/sim/scene.hpp"
#include "sgraph_slam/core/sim/simulator.hpp"

namespace sgraph::sim {
namespace {

LidarSettings real(std::uint64_t unit) {
  LidarSettings settings;
  settings.unit = real_unit(unit);
  return settings;
}

TEST(RealSensor, AUnitStaysTheSameAndOthersDiffer) {
  const SensorUnit a = real_unit(3);
  EXPECT_EQ(a.range_offset, real_unit(3).range_offset);
  EXPECT_NE(a.range_offset, real_unit(4).range_offset);
  EXPECT_NEAR(std::accumulate(a.range_offset.begin(), a.range_offset.end(), 0.0), 0, 1e-12);
}

// Table 9-1 of the manual, in millimetres from the lowest ring up.
TEST(RealSensor, LasersStandWhereTheManualHasThem) {
  const SensorUnit unit = real_unit(1);
  const double manual[8] = {11.2, 9.7, 8.1, 6.6, 5.1, 3.7, 2.2, 0.7};
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(1e3 * unit.origin_height[i], manual[i], 0.06);
    EXPECT_NEAR(unit.origin_height[15 - i], -unit.origin_height[i], 1e-12);
  }
}

// Head on, in a box, the mean range of each ring is off by its offset; what all rings share (shade of the wall) is taken out.
TEST(RealSensor, RangesCarryTheOffsetsOfTheRings) {
  World world = box_world(8, 5, 3);
  world.T_base_lidar.translation = {0, 0, 1.05};  // at half height
  const LidarSettings settings = real(7);
  const SimulatedScans scans = simulate_scans(world, 10, settings);
  std::map<int, std::pair<double, int>> sums;
  for (const CloudPtr& cloud : scans.scans) {
    for (const Point& p : cloud->points) {
      const Eigen::Vector3d at = p.position().cast<double>();
      if (std::abs(at.y()) > 0.35 * std::abs(at.x()) || std::abs(at.x()) < 2) continue;
      // The ray leaves the axis above or below the sensor's origin, at its own elevation.
      const double elevation = std::atan2(at.z(), at.head<2>().norm()) + settings.unit.elevation_offset[p.ring];
      const double expected = 4 / (std::cos(elevation) * std::abs(at.x()) / at.head<2>().norm());
      const double error = at.norm() - expected;
      if (std::abs(error) > 0.06) continue;  // windows there are none; a point between floor and wall
      sums[p.ring].first += error;
      ++sums[p.ring].second;
    }
  }
  ASSERT_EQ(sums.size(), 16U);
  double common = 0;
  for (const auto& [ring, sum] : sums) common += sum.first / sum.second / 16;
  for (const auto& [ring, sum] : sums) {
    EXPECT_GT(sum.second, 1000);
    EXPECT_NEAR(sum.first / sum.second - common, settings.unit.range_offset[static_cast<std::size_t>(ring)], 0.0015) << "ring " << ring;
  }
}

TEST(RealSensor, CloudsHaveNominalElevationsOnly) {
  const SimulatedScans scans = simulate_scans(box_world(8, 5), 1, real(2));
  for (const Point& p : scans.scans[0]->points) {
    const double elevation = std::atan2(static_cast<double>(p.z), std::hypot(static_cast<double>(p.x), static_cast<double>(p.y)));
    EXPECT_NEAR(elevation * 180 / M_PI, -15 + 2 * p.ring, 1e-4);
  }
}

constexpr const char* two_rooms = R"(
name: two_rooms
wall_thickness: 0.12
walls:
  - {path: [[0, 0], [9, 0], [9, 5], [0, 5], [0, 0]], thickness: 0.3}
  - [[4.5, 0], [4.5, 5]]
doors: [[4.5, 2.5]]
rooms: {left: [2, 2], right: [7, 2]}
building: {seed: 5}
route: {waypoints: [[1, 2.5], [7.5, 2.5]]}
)";

TEST(RealBuilding, WallsStayJoinedAndWithinTheirErrors) {
  const World planned = parse_world(two_rooms);
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
    World with_seed = planned;
    with_seed.errors.seed = seed;
    const World built = with_building_errors(with_seed);
    const std::vector<Wall>& walls = built.storeys[0].walls;
    const std::vector<Wall>& before = planned.storeys[0].walls;
    ASSERT_EQ(walls.size(), 5U);
    double moved = 0;
    for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((walls[i].q - walls[(i + 1) % 4].p).norm(), 1e-9);
    for (std::size_t i = 0; i < 5; ++i) {
      const double turned = std::acos(std::min(1.0, walls[i].direction().dot(before[i].direction()))) * 180 / M_PI;
      EXPECT_LT(turned, 0.55);
      EXPECT_LE(std::abs(walls[i].lean), std::tan(0.3 * M_PI / 180) + 1e-12);
      EXPECT_LE(std::abs(walls[i].bow), 0.004);
      moved = std::max(moved, (walls[i].p - before[i].p).norm());
    }
    EXPECT_GT(moved, 0.001);
    EXPECT_LT(moved, 0.06);
    // The partition ends on the centre lines of the long walls, where it did.
    for (const auto& [end, wall] : {std::pair{walls[4].p, walls[0]}, std::pair{walls[4].q, walls[2]}}) {
      const Eigen::Vector2d offset = end - wall.p;
      EXPECT_LT(std::abs(offset.x() * wall.direction().y() - offset.y() * wall.direction().x()), 1e-9);
    }
    EXPECT_NEAR(built.storeys[0].rooms[0].width.y(), 4.7, 0.07);
  }
}

// No ray escapes through a joint: everything that a sensor within sees is within.
TEST(RealBuilding, IsClosed) {
  const World built = with_building_errors(parse_world(two_rooms));
  const SimulatedScans scans = simulate_scans(built, 3, LidarSettings{});
  for (const CloudPtr& cloud : scans.scans) {
    EXPECT_GT(cloud->size(), 28000U);
    for (const Point& p : cloud->points) EXPECT_LT(p.position().norm(), 10.5F);
  }
}

TEST(RealBuilding, TheRobotStandsOnTheFloorAsItIs) {
  const World built = with_building_errors(parse_world(two_rooms));
  const Motion motion = motion_along_route(built);
  const Pose start = motion.pose_at(0);
  EXPECT_NEAR(start.translation.z(), built.motion.base_height + built.storeys[0].floor_shape(start.translation.head<2>()), 1e-9);
  EXPECT_GT(std::abs(built.storeys[0].floor_shape({1, 1}) - built.storeys[0].floor_shape({8, 4})), 1e-4);
}

// Where no slab lies between two storeys: walls end at the slab's two sides, or the upper storey would have kerbs and the lower one beams.
TEST(RealBuilding, WallsOfAStoreyEndAtTheNextOne) {
  const World built = with_building_errors(read_world("worlds/stairs.yaml"));
  const Storey& below = built.storeys[0];
  const Storey& above = built.storeys[1];
  ASSERT_FALSE(above.floor_shape.flat());
  int at_slab = 0;
  for (const Surface& surface : surfaces_of(built)) {
    if (surface.kind != SurfaceKind::wall) continue;
    for (const Eigen::Vector3d& corner : surface.outline) {
      if (std::abs(corner.z() - above.elevation) > 0.2) continue;
      ++at_slab;
      const double over = corner.z() - above.elevation - above.floor_shape(corner.head<2>());
      EXPECT_LT(std::abs(over), 0.025) << "what the floor rises and falls by along the wall";
    }
  }
  EXPECT_GT(at_slab, 50);
  EXPECT_EQ(below.ceiling_shape({3, 3}), above.floor_shape({3, 3}));
}

}  // namespace
}  // namespace sgraph::sim
