#include "sgraph_slam/core/places/rooms.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/plan.hpp"

namespace sgraph {
namespace {

const RoomParams params;

std::vector<PlaneId> walls_of(const RoomShape& room) { return {room.walls.begin(), room.walls.end()}; }

TEST(Rooms, FourWallsWithADoorAreOne) {
  Plan plan;
  const auto box = plan.box(0, 0, 6, 4, {{2, 3}});
  const RoomSearch found = find_room(plan.walls, {1, 1}, 0, params);
  ASSERT_TRUE(found.room) << to_string(found.verdict);
  EXPECT_EQ(walls_of(*found.room), box);
  EXPECT_NEAR((found.room->area.center - Eigen::Vector2d(3, 2)).norm(), 0, 1e-12);
  EXPECT_NEAR((found.room->area.size - Eigen::Vector2d(6, 4)).norm(), 0, 1e-12);
  EXPECT_NEAR(found.room->coverage, 19.0 / 20, 1e-12);
}

// The same building at any heading and place gives the same room, in the axes of the reference.
TEST(Rooms, AreTheSameAtAnyHeading) {
  Plan plan;
  const auto box = plan.box(0, 0, 6, 4, {{2, 3}});
  const Eigen::Vector2d shift(40, -25);
  for (int degrees = -180; degrees < 180; degrees += 7) {
    const double yaw = degrees * M_PI / 180;
    const Eigen::Rotation2Dd R(yaw);
    const RoomSearch found = find_room(plan.moved(yaw, shift), R * Eigen::Vector2d(5.5, 0.5) + shift, yaw + 0.1, params);
    ASSERT_TRUE(found.room) << degrees << " " << to_string(found.verdict);
    EXPECT_EQ(walls_of(*found.room), box) << degrees;
    EXPECT_NEAR((found.room->area.center - (R * Eigen::Vector2d(3, 2) + shift)).norm(), 0, 1e-9);
    EXPECT_NEAR((found.room->area.size - Eigen::Vector2d(6, 4)).norm(), 0, 1e-9);
    EXPECT_NEAR(std::remainder(found.room->area.yaw - yaw, 2 * M_PI), 0, 1e-9);
  }
}

// A quarter turn of the reference renames the sides and swaps the widths, but it is the same rectangle.
TEST(Rooms, SidesFollowTheReferenceYaw) {
  Plan plan;
  const auto box = plan.box(0, 0, 6, 4);
  const RoomSearch found = find_room(plan.walls, {1, 1}, M_PI / 2, params);
  ASSERT_TRUE(found.room);
  // The new x axis is the old y: -x' is the old -y, +x' the old +y, -y' the old +x, +y' the old -x.
  EXPECT_EQ(walls_of(*found.room), (std::vector<PlaneId>{box[2], box[3], box[1], box[0]}));
  EXPECT_NEAR((found.room->area.size - Eigen::Vector2d(4, 6)).norm(), 0, 1e-12);
  EXPECT_NEAR(found.room->area.yaw, M_PI / 2, 1e-12);
}

TEST(Rooms, ACupboardBeforeALongerWallIsFurniture) {
  Plan plan;
  auto box = plan.box(0, 0, 6, 5);
  plan.walls.pop_back();  // the -x wall is seen in two pieces, beside the cupboard
  box[0] = plan.add({0, 5}, {0, 0}, {{1, 3.6}});
  plan.add({0.5, 4}, {0.5, 1.4});
  const RoomSearch found = find_room(plan.walls, {3, 2}, 0, params);
  ASSERT_TRUE(found.room) << to_string(found.verdict);
  EXPECT_EQ(walls_of(*found.room), box);
  EXPECT_NEAR(found.room->area.size.x(), 6, 1e-12);
}

TEST(Rooms, NeighboursBehindAThinWallStayTwo) {
  Plan plan;
  const auto left = plan.box(0, 0, 5, 4, {{2, 3}});
  const auto right = plan.box(5.15, 0, 10.15, 4, {{2, 3}});
  const RoomSearch in_left = find_room(plan.walls, {2, 2}, 0, params);
  const RoomSearch in_right = find_room(plan.walls, {8, 2}, 0, params);
  ASSERT_TRUE(in_left.room);
  ASSERT_TRUE(in_right.room);
  EXPECT_EQ(walls_of(*in_left.room), left);
  EXPECT_EQ(walls_of(*in_right.room), right);
}

// One long face bounds both rooms at their -y side.
TEST(Rooms, ShareALongWall) {
  Plan plan;
  const PlaneId shared = plan.add({0, 0}, {10.15, 0}, {{2, 3}, {7, 8}});
  plan.add({5, 0}, {5, 4});
  plan.add({10.15, 4}, {0, 4});
  plan.add({0, 4}, {0, 0});
  plan.add({10.15, 0}, {10.15, 4});
  plan.add({5.15, 4}, {5.15, 0});
  const RoomSearch a = find_room(plan.walls, {2, 2}, 0, params);
  const RoomSearch b = find_room(plan.walls, {8, 2}, 0, params);
  ASSERT_TRUE(a.room);
  ASSERT_TRUE(b.room);
  EXPECT_EQ(a.room->walls[low_y], shared);
  EXPECT_EQ(b.room->walls[low_y], shared);
  EXPECT_NEAR(a.room->area.size.x(), 5, 1e-12);
  EXPECT_NEAR(b.room->area.size.x(), 5, 1e-12);
}

// Two boxes with nothing known of the wall between but its far faces: the free sides do not look at each other.
TEST(Rooms, TheTwoFacesOfAWallAreNoPair) {
  Plan plan;
  plan.add({0, 0}, {4, 0});
  plan.add({4, -0.2}, {0, -0.2});
  const auto pair = facing_pair(plan.walls[0], plan.walls[1], 0.17);
  ASSERT_TRUE(pair);
  EXPECT_NEAR(pair->width, -0.2, 1e-12);
  const auto other_way = facing_pair(plan.walls[1], plan.walls[0], 0.17);
  ASSERT_TRUE(other_way);
  EXPECT_NEAR(other_way->width, -0.2, 1e-12);
}

TEST(Rooms, ACorridorIsNone) {
  Plan plan;
  plan.box(0, 0, 10, 2.05, {{3, 4}});
  EXPECT_EQ(find_room(plan.walls, {9, 1}, 0, params).verdict, RoomVerdict::corridor);
}

TEST(Rooms, AnLShapedPlaceIsNoRectangle) {
  Plan plan;
  plan.add({0, 0}, {6, 0});
  plan.add({6, 0}, {6, 3});
  plan.add({6, 3}, {3, 3});
  plan.add({3, 3}, {3, 6});
  plan.add({3, 6}, {0, 6});
  plan.add({0, 6}, {0, 0});
  RoomParams strict = params;
  strict.min_side_coverage = 0.55;
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(1, 1), Eigen::Vector2d(5, 1), Eigen::Vector2d(1, 5)}) {
    EXPECT_FALSE(find_room(plan.walls, p, 0, strict).room) << p.transpose();
  }
}

TEST(Rooms, AHalfSeenRoomWaits) {
  Plan plan;
  plan.add({0, 0}, {6, 0});
  plan.add({6, 0}, {6, 4}, {{1, 4}});
  plan.add({6, 4}, {0, 4}, {{0, 4}});
  plan.add({0, 4}, {0, 0});
  EXPECT_EQ(find_room(plan.walls, {1, 1}, 0, params).verdict, RoomVerdict::uncovered);
}

TEST(Rooms, AWallThroughTheInsideCuts) {
  Plan plan;
  plan.box(0, 0, 8, 6);
  plan.add({4, 0}, {4, 6}, {{2.5, 3.5}});  // one face is enough, and its door doesn't help
  EXPECT_FALSE(find_room(plan.walls, {6, 3}, 0, params).room);
  const RoomSearch left = find_room(plan.walls, {2, 3}, 0, params);
  ASSERT_TRUE(left.room);
  EXPECT_NEAR(left.room->area.size.x(), 4, 1e-12);
}

TEST(Rooms, ATableDoesNotCut) {
  Plan plan;
  plan.box(0, 0, 8, 6);
  plan.add({4, 2}, {4, 4});
  plan.add({4.8, 4}, {4.8, 2});
  const RoomSearch found = find_room(plan.walls, {2, 3}, 0, params);
  ASSERT_TRUE(found.room) << to_string(found.verdict);
  EXPECT_NEAR(found.room->area.size.x(), 8, 1e-12);
}

// A desk and a cabinet in line make one plane across the room, but not one as high as its walls.
TEST(Rooms, WhatIsLowerThanTheWallsDoesNotCut) {
  for (const double height : {1.2, 2.6}) {
    Plan plan;
    plan.box(0, 0, 8, 6);
    plan.add({5, 0}, {5, 6});
    for (Wall& wall : plan.walls) wall.height = 2.8;
    plan.walls.back().height = height;
    const RoomSearch found = find_room(plan.walls, {2, 3}, 0, params);
    EXPECT_EQ(found.room && found.room->area.size.x() > 7.9, height < 2) << height;
  }
}

TEST(Rooms, AnObliqueWallThroughTheInsideCuts) {
  Plan plan;
  plan.box(0, 0, 6, 6);
  plan.add({0.5, 0.5}, {5, 5.5});
  EXPECT_EQ(find_room(plan.walls, {1, 4}, 0, params).verdict, RoomVerdict::cut);
}

TEST(Rooms, LimitsOnWidthsAreTested) {
  Plan plan;
  plan.box(0, 0, 1.5, 1.8);
  EXPECT_EQ(find_room(plan.walls, {1, 1}, 0, params).verdict, RoomVerdict::narrow);
  RoomParams paper = params;
  paper.max_width = 6.0;
  Plan large;
  large.box(0, 0, 7, 5);
  EXPECT_FALSE(find_room(large.walls, {1, 1}, 0, paper).room);
  EXPECT_TRUE(find_room(large.walls, {1, 1}, 0, params).room);
}

TEST(Rooms, JudgingFollowsTheWalls) {
  Plan plan;
  plan.box(0, 0, 6, 4, {{2, 3}});
  RoomShape room = *find_room(plan.walls, {1, 1}, 0, params).room;
  plan.walls[1].offset += 0.3;  // +x wall moves out
  RoomSearch again = judge_room(plan.walls, room, params, 0.2);
  ASSERT_TRUE(again.room);
  EXPECT_NEAR(again.room->area.size.x(), 6.3, 1e-12);
  EXPECT_EQ(again.room->walls, room.walls);
  plan.walls.erase(plan.walls.begin());
  EXPECT_EQ(judge_room(plan.walls, room, params, 0.2).verdict, RoomVerdict::no_walls);
}

// A face seen through the door, a wall's thickness behind the real one, explains as much of the outline but is hardly seen itself.
TEST(Rooms, TheWallThatIsSeenWinsOverAPieceBehindIt) {
  Plan plan;
  const auto box = plan.box(0, 0, 6, 4, {{2, 3}});
  plan.add({0.5, -0.15}, {2.6, -0.15});
  const RoomSearch found = find_room(plan.walls, {3, 2}, 0, params);
  ASSERT_TRUE(found.room);
  EXPECT_EQ(walls_of(*found.room), box);
}

// A row of cabinets over most of a side, a step before the wall: the larger rectangle stands the tests too, so it is the room.
TEST(Rooms, OfRectanglesThatStandTheTestsTheLargerOneWins) {
  Plan plan;
  const auto box = plan.box(0, 0, 6, 5);
  plan.add({0.6, 4.4}, {0.6, 1.4});
  const RoomSearch found = find_room(plan.walls, {3, 2}, 0, params);
  ASSERT_TRUE(found.room);
  EXPECT_EQ(walls_of(*found.room), box);
}

// A short piece a few degrees off lies where it has been seen, not where its line would be beside a distant robot.
TEST(Rooms, AnObliquePieceIsNotProlonged) {
  Plan plan;
  plan.add({0, 0}, {0.5, 0.06});
  const PlaceView view = view_from(plan.walls, {10, 3}, 0, 50, params.parallel);
  ASSERT_EQ(view.faces[low_y].size(), 1U);
  EXPECT_NEAR(view.faces[low_y][0].position, 0.06, 1e-9);
}

}  // namespace
}  // namespace sgraph
