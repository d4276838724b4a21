#include "sgraph_slam/core/places/corridors.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/plan.hpp"

namespace sgraph {
namespace {

const CorridorParams params;

TEST(Corridors, TwoLongWallsAreOneAtAnyHeading) {
  Plan plan;
  const PlaneId right = plan.add({0, 0}, {20, 0}, {{3, 4}, {9, 10}});
  const PlaneId left = plan.add({19, 2}, {1, 2});
  const Eigen::Vector2d shift(-30, 12);
  for (int degrees = -180; degrees < 180; degrees += 7) {
    const double yaw = degrees * M_PI / 180;
    const Eigen::Rotation2Dd R(yaw);
    const CorridorSearch found = find_corridor(plan.moved(yaw, shift), R * Eigen::Vector2d(5, 1) + shift, yaw, params);
    ASSERT_TRUE(found.corridor) << degrees << to_string(found.verdict);
    EXPECT_EQ(found.corridor->walls[0], right);
    EXPECT_EQ(found.corridor->walls[1], left);
    EXPECT_NEAR((found.corridor->area.center - (R * Eigen::Vector2d(10, 1) + shift)).norm(), 0, 1e-9);
    EXPECT_NEAR((found.corridor->area.size - Eigen::Vector2d(18, 2)).norm(), 0, 1e-9);
    EXPECT_NEAR(std::remainder(found.corridor->area.yaw - yaw, 2 * M_PI), 0, 1e-9);
    EXPECT_FALSE(found.corridor->closed[0]);
  }
}

TEST(Corridors, OppositeHeadingIsTheSameCorridorSeenFromTheOtherEnd) {
  Plan plan;
  const PlaneId right = plan.add({0, 0}, {20, 0});
  const PlaneId left = plan.add({20, 2}, {0, 2});
  const CorridorSearch found = find_corridor(plan.walls, {5, 1}, M_PI, params);
  ASSERT_TRUE(found.corridor);
  EXPECT_EQ(found.corridor->walls[0], left);
  EXPECT_EQ(found.corridor->walls[1], right);
  EXPECT_NEAR(std::abs(std::remainder(found.corridor->area.yaw, 2 * M_PI)), M_PI, 1e-12);
}

TEST(Corridors, EndWallsCloseThem) {
  Plan plan;
  plan.box(0, 0, 18.85, 2.05, {{3, 4}});
  const CorridorSearch found = find_corridor(plan.walls, {9, 1}, 0, params);
  ASSERT_TRUE(found.corridor) << to_string(found.verdict);
  EXPECT_TRUE(found.corridor->closed[0] && found.corridor->closed[1]);
  EXPECT_NEAR(found.corridor->area.size.x(), 18.85, 1e-12);
}

// Two crossing corridors: each wall is interrupted where the other passes, in several planes.
TEST(Corridors, CrossEachOther) {
  Plan plan;
  plan.add({0, 0}, {9, 0});
  plan.add({11, 0}, {24, 0});
  plan.add({9, 2}, {0, 2});
  plan.add({24, 2}, {11, 2});
  plan.add({9, 0}, {9, -10});
  plan.add({11, -10}, {11, 0});
  plan.add({9, 10}, {9, 2});
  plan.add({11, 2}, {11, 10});
  const CorridorSearch along_x = find_corridor(plan.walls, {4, 1}, 0, params);
  ASSERT_TRUE(along_x.corridor) << to_string(along_x.verdict);
  EXPECT_NEAR(along_x.corridor->area.size.x(), 24, 1e-12);
  EXPECT_NEAR(along_x.corridor->area.size.y(), 2, 1e-12);
  const CorridorSearch along_y = find_corridor(plan.walls, {10, -5}, 0, params);
  ASSERT_TRUE(along_y.corridor) << to_string(along_y.verdict);
  EXPECT_NEAR(along_y.corridor->area.size.x(), 20, 1e-12);
  EXPECT_NEAR(std::abs(along_y.corridor->area.yaw), M_PI / 2, 1e-9);
}

TEST(Corridors, ASmallClosedPlaceIsARoom) {
  Plan plan;
  plan.box(0, 0, 6, 2.5);
  EXPECT_EQ(find_corridor(plan.walls, {1, 1}, 0, params).verdict, CorridorVerdict::room);
}

TEST(Corridors, TwoFacesOfAWallAreNone) {
  Plan plan;
  plan.add({0, 0}, {20, 0});
  plan.add({20, -1.5}, {0, -1.5});  // back to back, at a corridor's width
  EXPECT_FALSE(find_corridor(plan.walls, {5, -0.7}, 0, params).corridor);
  EXPECT_FALSE(find_corridor(plan.walls, {5, 1}, 0, params).corridor);
}

TEST(Corridors, WallsThatDoNotOverlapAreNone) {
  Plan plan;
  plan.add({0, 0}, {8, 0});
  plan.add({30, 2}, {14, 2});
  EXPECT_FALSE(find_corridor(plan.walls, {7.5, 1}, 0, params).corridor);
  EXPECT_FALSE(find_corridor(plan.walls, {15, 1}, 0, params).corridor);
}

TEST(Corridors, AWallAlongTheInsideCuts) {
  Plan plan;
  plan.add({0, 0}, {12, 0});
  plan.add({12, 3}, {0, 3});
  plan.add({12, 1.4}, {0, 1.4});
  plan.add({0, 1.5}, {12, 1.5});
  const CorridorSearch lower = find_corridor(plan.walls, {5, 0.7}, 0, params);
  ASSERT_TRUE(lower.corridor);
  EXPECT_NEAR(lower.corridor->area.size.y(), 1.4, 1e-12);
}

TEST(Corridors, LimitsAreTested) {
  Plan plan;
  plan.add({0, 0}, {3.5, 0});
  plan.add({3.5, 1.5}, {0, 1.5});
  EXPECT_EQ(find_corridor(plan.walls, {2, 1}, 0, params).verdict, CorridorVerdict::short_);
  Plan wide;
  wide.add({0, 0}, {20, 0});
  wide.add({20, 3.8}, {0, 3.8});
  EXPECT_EQ(find_corridor(wide.walls, {2, 1}, 0, params).verdict, CorridorVerdict::no_walls);
}

}  // namespace
}  // namespace sgraph
