#include "sgraph_slam/core/registration/surface_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace sgraph {
namespace {

using Eigen::Vector3d;

// Points on the wall x = `x`, 4 m wide and 2 m high, with range noise along x.
void insert_wall(SurfaceMap& map, double x, const Vector3d& sensor, double noise, std::uint32_t seed, int count = 4000) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit;
  std::normal_distribution<double> normal(0, noise);
  for (int i = 0; i < count; ++i) map.insert({x + normal(random), 4 * unit(random), 2 * unit(random)}, sensor);
}

TEST(SurfaceMap, KeepsTheTwoFacesOfAWallApart) {
  const Vector3d left(-2, 2, 1);
  const Vector3d right(2.3, 2, 1);
  for (const bool two_faces : {true, false}) {
    SurfaceMapParams params;
    params.two_faces = two_faces;
    SurfaceMap map(params);
    insert_wall(map, 0.10, left, 0.01, 1);
    map.update();
    insert_wall(map, 0.22, right, 0.01, 2);
    map.update();
    const Surface* from_left = map.match({0.1, 1.6, 0.6}, left, 0.5);
    const Surface* from_right = map.match({0.22, 1.6, 0.6}, right, 0.5);
    if (!two_faces) {
      ASSERT_NE(from_left, nullptr);
      EXPECT_EQ(from_right, nullptr) << "what one side saw must not pull the other by the wall's thickness";
      continue;
    }
    ASSERT_NE(from_left, nullptr);
    ASSERT_NE(from_right, nullptr);
    EXPECT_NEAR(from_left->mean.x(), 0.10, 0.003);
    EXPECT_NEAR(from_right->mean.x(), 0.22, 0.003);
    EXPECT_LT(from_left->normal.x(), -0.99);
    EXPECT_GT(from_right->normal.x(), 0.99);
  }
}

TEST(SurfaceMap, AWallSeenFromAheadAndThenFromBehindIsOneFace) {
  SurfaceMap map({});
  insert_wall(map, 0.1, {-1, -6, 1}, 0.01, 3);
  map.update();
  insert_wall(map, 0.1, {-1, 10, 1}, 0.01, 4);
  map.update();
  const Surface* ahead = map.match({0.1, 1.5, 0.5}, {-1, -6, 1}, 0.3);
  const Surface* behind = map.match({0.1, 1.5, 0.5}, {-1, 10, 1}, 0.3);
  ASSERT_NE(ahead, nullptr);
  EXPECT_EQ(ahead, behind);
}

// A few points of the floor at the foot of a wall would make its Gaussian lean, by degrees, and leave it flat enough to be used.
TEST(SurfaceMap, AKnownWallTakesNoPointsOfTheFloorAtItsFoot) {
  SurfaceMap map({});
  const Vector3d sensor(3, 0.5, 0.7);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit;
  std::normal_distribution<double> noise(0, 0.01);
  for (int i = 0; i < 100; ++i) map.insert({0.1 + noise(random), unit(random), unit(random)}, sensor);
  map.update();
  for (int i = 0; i < 8; ++i) map.insert({0.2, unit(random), 0.02}, sensor);
  for (int i = 0; i < 20; ++i) map.insert({0.1 + noise(random), unit(random), unit(random)}, sensor);
  map.update();
  const Surface* wall = map.match({0.1, 0.5, 0.5}, sensor, 0.1);
  ASSERT_NE(wall, nullptr);
  EXPECT_LT(std::abs(wall->normal.z()), 0.01);
}

TEST(SurfaceMap, AStripeIsASurfaceOnlyWithItsPointsNormals) {
  const Vector3d sensor(0.5, 0.5, 0.7);
  const Vector3d at(5.5, 0.5, 0);
  for (const bool with_normals : {false, true}) {
    SurfaceMap map({});
    insert_wall(map, 8.0, sensor, 0.01, 6);  // shows the noise
    map.update();
    const std::optional<Eigen::Vector3f> normal = with_normals ? std::optional<Eigen::Vector3f>({0, 0, 1}) : std::nullopt;
    for (int i = 0; i < 20; ++i) map.insert({5.5, 0.05 * i, 0.001 * (i % 3)}, sensor, normal);
    map.update();
    const Surface* floor = map.match(at, sensor, 0.1);
    ASSERT_EQ(floor != nullptr, with_normals);
    if (floor != nullptr) {
      EXPECT_GT(floor->normal.z(), 0.9999);
    }
  }
}

TEST(SurfaceMap, TakesTheNoiseFromTheData) {
  for (const double noise : {0.01, 0.02, 0.04}) {
    SurfaceMap map({});
    insert_wall(map, 0.1, {-2, 2, 1}, noise, 5, 8000);
    insert_wall(map, 3.1, {-2, 2, 1}, noise, 6, 8000);
    map.update();
    EXPECT_NEAR(map.noise(), noise, 0.2 * noise);
    EXPECT_NE(map.match({0.1, 1.5, 0.5}, {-2, 2, 1}, 0.3), nullptr) << "a wall is flat whatever the sensor's noise";
  }
}

TEST(SurfaceMap, ASingleStripeIsNotASurface) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit;
  std::normal_distribution<double> normal(0, 0.01);
  SurfaceMap map({});
  for (int i = 0; i < 4000; ++i) map.insert({0.1 + normal(random), 4 * unit(random), 1.1 + 0.1 * normal(random)}, {-2, 2, 1});
  map.update();
  EXPECT_EQ(map.match({0.1, 1.5, 1.1}, {-2, 2, 1}, 0.3), nullptr);
}

TEST(SurfaceMap, NothingMatchesBeyondTheGateOrFromBehind) {
  SurfaceMap map({});
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(map.match({0, 0, 0}, {1, 0, 0}, 1.0), nullptr);
  insert_wall(map, 0.1, {-2, 2, 1}, 0.01, 8);
  map.update();
  EXPECT_NE(map.match({0.3, 1.5, 0.5}, {-2, 2, 1}, 0.25), nullptr);
  EXPECT_EQ(map.match({0.3, 1.5, 0.5}, {-2, 2, 1}, 0.15), nullptr);
  EXPECT_EQ(map.match({0.1, 1.5, 0.5}, {2, 2, 1}, 0.25), nullptr);
}

// A corner of a hall that is looked at for hours.
TEST(SurfaceMap, CountsAsManyPointsAsItMayBeAskedTo) {
  SurfaceMapParams params;
  params.max_points = 100000;
  SurfaceMap map(params);
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0, 1);
  std::normal_distribution<double> noise(0, 0.005);
  for (int i = 0; i < 400000; ++i) map.insert({0.1 + noise(random), 0.02 + 0.1 * unit(random), 0.02 + 0.1 * unit(random)}, {-2, 0.1, 0.1});
  map.update();
  const Surface* found = map.match({0.12, 0.08, 0.08}, {-2, 0.1, 0.1}, 0.05);
  ASSERT_NE(found, nullptr);
  EXPECT_GT(std::abs(found->normal.x()), 0.99);
  EXPECT_LT((found->mean - Vector3d(0.1, 0.07, 0.07)).norm(), 0.06);
  EXPECT_EQ(map.match({0.2, 0.08, 0.08}, {-2, 0.1, 0.1}, 0.05), nullptr);
}

TEST(SurfaceMap, MemoryIsBoundByTheAreaAndNotByTheScans) {
  SurfaceMap map({});
  insert_wall(map, 0.1, {-2, 2, 1}, 0.01, 9, 20000);
  map.update();
  const std::size_t after_one = map.voxel_count();
  for (std::uint32_t i = 0; i < 20; ++i) insert_wall(map, 0.1, {-2, 2, 1}, 0.01, 10 + i, 20000);
  map.update();
  EXPECT_LE(map.voxel_count(), after_one + after_one / 10);
}

}  // namespace
}  // namespace sgraph
