#include "sgraph_slam/core/places/find_places.hpp"

#include <gtest/gtest.h>

#include "scanned_plan.hpp"

namespace sgraph {
namespace {

FoundPlaces found_in(const ScannedPlan& scanned) { return find_places(scanned.space, scanned.plan.walls, scanned.path, 0, PlaceParams{}); }

TEST(FindPlaces, ARectangleIsARoomWithTheWidthsOfItsWalls) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {6, 0}, {6, 4}, {0, 4}});
  scanned.walk({{1, 1}, {5, 3}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 1U);
  EXPECT_EQ(found.places[0].kind, PlaceKind::room);
  EXPECT_NEAR(found.places[0].area.size.x(), 6, 1e-9);
  EXPECT_NEAR(found.places[0].area.size.y(), 4, 1e-9);
  EXPECT_NEAR((found.places[0].area.center - Eigen::Vector2d(3, 2)).norm(), 0, 1e-9);
  EXPECT_EQ(found.places[0].walls, (std::array<PlaneId, 4>{{{3}, {1}, {0}, {2}}}));  // -x, +x, -y, +y
  EXPECT_NEAR(signed_area(found.places[0].outline.polygon), 24, 1e-9);
}

TEST(FindPlaces, ALongNarrowRectangleIsACorridor) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {12, 0}, {12, 2}, {0, 2}});
  scanned.walk({{1, 1}, {11, 1}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 1U);
  EXPECT_EQ(found.places[0].kind, PlaceKind::corridor);
  EXPECT_NEAR(found.places[0].area.size.x(), 12, 1e-9);
  EXPECT_NEAR(found.places[0].area.size.y(), 2, 1e-9);
  EXPECT_EQ(found.places[0].walls[0], PlaneId{0});  // right hand of its direction
  EXPECT_EQ(found.places[0].walls[1], PlaneId{2});
}

TEST(FindPlaces, AnLShapeIsOneHall) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {9, 0}, {9, 4}, {5, 4}, {5, 8}, {0, 8}});
  scanned.walk({{1, 1}, {7, 2}, {3, 3}, {3, 6}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 1U);
  EXPECT_EQ(found.places[0].kind, PlaceKind::hall);
  EXPECT_EQ(found.places[0].outline.polygon.size(), 6U);
  EXPECT_NEAR(signed_area(found.places[0].outline.polygon), 56, 1e-6);
  for (const PlaceSide& side : found.places[0].outline.sides) EXPECT_TRUE(side.plane.valid());
}

TEST(FindPlaces, OutlinesThatAreNoRectangles) {
  const std::vector<std::vector<Eigen::Vector2d>> outlines{
      {{0, 0}, {7, 0}, {5, 5}, {0, 5}},                                      // trapezoid
      {{0, 0}, {6, 0}, {6, 5}, {4, 7}, {0, 7}},                              // cut corner
      {{2, 0}, {5, 0}, {7, 2}, {7, 5}, {5, 7}, {2, 7}, {0, 5}, {0, 2}},      // octagon
      {{0, 0}, {6, 0}, {6, 5}, {4, 5}, {4, 6.5}, {2, 6.5}, {2, 5}, {0, 5}},  // alcove
      {{0, 0}, {16, 0}, {16, 11}, {0, 11}},                                  // a large hall that is a rectangle
  };
  for (const auto& outline : outlines) {
    ScannedPlan scanned;
    scanned.face(outline);
    const Eigen::Vector2d middle = centroid(outline);
    scanned.walk({middle - Eigen::Vector2d(1, 1), middle, middle + Eigen::Vector2d(0.5, 1)});
    const FoundPlaces found = found_in(scanned);
    ASSERT_EQ(found.places.size(), 1U);
    EXPECT_EQ(found.places[0].outline.polygon.size(), outline.size());
    EXPECT_NEAR(signed_area(found.places[0].outline.polygon), signed_area(outline), 1e-6);
  }
}

TEST(FindPlaces, ADoorPartsTwoRooms) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {10, 0}, {10, 4}, {0, 4}});
  scanned.wall({5, 0}, {5, 4}, {{1.5, 2.4}});
  scanned.walk({{1, 1}, {3, 1.95}, {7, 1.95}, {9, 3}});
  FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 2U);
  for (const FoundPlace& place : found.places) {
    EXPECT_EQ(place.kind, PlaceKind::room);
    EXPECT_NEAR(place.area.area(), 4.925 * 4, 1e-6);
  }
  ASSERT_EQ(found.doors.size(), 1U);
  measure_door(scanned.space, found.doors[0]);
  EXPECT_NEAR(found.doors[0].width, 0.9, 0.05);
  EXPECT_NEAR((found.doors[0].position - Eigen::Vector2d(5, 1.95)).norm(), 0, 0.05);
  EXPECT_NEAR(std::abs(std::cos(found.doors[0].yaw)), 1, 1e-6);
}

TEST(FindPlaces, AnOpeningJoinsWhenItIsMoreThanHalfAsWideAsTheNarrowerPlace) {
  for (const double opening : {2.2, 4.0}) {
    ScannedPlan scanned;
    scanned.face({{0, 0}, {12, 0}, {12, 6}, {0, 6}});
    scanned.wall({6, 0}, {6, 6}, {{3 - opening / 2, 3 + opening / 2}});
    scanned.walk({{2, 2}, {4, 3}, {8, 3}, {10, 4}});
    EXPECT_EQ(found_in(scanned).places.size(), opening > 3 ? 1U : 2U) << opening;
  }
}

TEST(FindPlaces, FurnitureAndColumnsBoundNothing) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {8, 0}, {8, 6}, {0, 6}});
  scanned.plan.add({1, 0.6}, {1, 0});  // a wardrobe at the wall: sides and front
  scanned.plan.add({2.5, 0.6}, {1, 0.6});
  scanned.plan.add({2.5, 0}, {2.5, 0.6});
  scanned.plan.add({5, 3}, {5, 3.4});  // a column
  scanned.plan.add({5.4, 3.4}, {5.4, 3});
  scanned.walk({{2, 2}, {4, 4.5}, {6.5, 4.5}, {6.5, 1.5}, {3.5, 1.5}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 1U);
  EXPECT_EQ(found.places[0].kind, PlaceKind::room);
  EXPECT_NEAR(found.places[0].area.area(), 48, 1e-6);
}

TEST(FindPlaces, ACorridorEndsWhereItOpensIntoAHall) {
  ScannedPlan scanned;
  scanned.face({{0, 2}, {10, 2}, {10, 0}, {18, 0}, {18, 8}, {10, 8}, {10, 4}, {0, 4}});
  scanned.walk({{1, 3}, {9, 3}, {14, 4}, {15, 6}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 2U);
  const auto& corridor = found.places[0].kind == PlaceKind::corridor ? found.places[0] : found.places[1];
  const auto& hall = found.places[0].kind == PlaceKind::corridor ? found.places[1] : found.places[0];
  EXPECT_EQ(corridor.kind, PlaceKind::corridor);
  EXPECT_NEAR(corridor.area.size.y(), 2, 1e-9);
  EXPECT_NEAR(corridor.area.size.x(), 10, 0.15);
  EXPECT_NEAR(signed_area(hall.outline.polygon), 64, 1);
}

TEST(FindPlaces, CorridorsThatCrossAreOnePieceOfFloor) {
  ScannedPlan scanned;
  scanned.face({{0, 8}, {8, 8}, {8, 0}, {10, 0}, {10, 8}, {18, 8}, {18, 10}, {10, 10}, {10, 18}, {8, 18}, {8, 10}, {0, 10}});
  scanned.walk({{1, 9}, {17, 9}, {9, 9}, {9, 1}, {9, 17}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 2U);
  for (const FoundPlace& place : found.places) {
    EXPECT_EQ(place.kind, PlaceKind::corridor);
    EXPECT_NEAR(place.area.size.x(), 18, 1e-6);
  }
  ASSERT_EQ(found.branchings.size(), 1U);
  EXPECT_EQ(found.branchings[0].parts, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(found.branchings[0].outline.polygon.size(), 12U);
  EXPECT_NEAR(area(found.branchings[0].outline), 68, 1e-6);
}

TEST(FindPlaces, CorridorsAroundABlockHaveAHole) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {14, 0}, {14, 12}, {0, 12}});
  scanned.face({{2, 2}, {2, 10}, {12, 10}, {12, 2}});
  scanned.walk({{1, 1}, {13, 1}, {13, 11}, {1, 11}, {1, 2}});
  const FoundPlaces found = found_in(scanned);
  EXPECT_EQ(found.places.size(), 4U);
  ASSERT_EQ(found.branchings.size(), 1U);
  EXPECT_EQ(found.branchings[0].parts.size(), 4U);
  EXPECT_EQ(found.branchings[0].outline.holes.size(), 1U);
  EXPECT_NEAR(area(found.branchings[0].outline), 88, 1e-6);
}

TEST(FindPlaces, ARoomWithinAHallIsAHoleOfIt) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {16, 0}, {16, 12}, {0, 12}});
  scanned.wall({5, 4}, {9, 4});
  scanned.wall({9, 4}, {9, 8}, {{1.5, 2.4}});
  scanned.wall({9, 8}, {5, 8});
  scanned.wall({5, 8}, {5, 4});
  scanned.walk({{2, 2}, {12, 2}, {12, 5.95}, {7, 5.95}, {12, 5.95}, {12, 10}, {2, 10}, {2, 3}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 2U);
  const bool hall_first = area(found.places[0].outline) > area(found.places[1].outline);
  EXPECT_NEAR(area(found.places[hall_first ? 0 : 1].outline), 192 - 4.15 * 4.15, 0.01);
  EXPECT_NEAR(area(found.places[hall_first ? 1 : 0].outline), 3.85 * 3.85, 0.01);
  EXPECT_EQ(found.doors.size(), 1U);
}

// A cabinet as high as the room in its corner: a step of the outline, and four walls all the same.
TEST(FindPlaces, ARoomWithACabinetInItsCornerHasFourWalls) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {4.8, 0}, {4.8, 1.2}, {6, 1.2}, {6, 5}, {0, 5}});
  scanned.walk({{1, 1}, {4, 1}, {5, 4}, {1, 4}, {1, 1}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 1U);
  const FoundPlace& room = found.places[0];
  EXPECT_EQ(room.kind, PlaceKind::room);
  EXPECT_NEAR(area(room.outline), 30 - 1.2 * 1.2, 0.01);
  Eigen::Vector2d size = room.area.size;
  if (size.x() < size.y()) std::swap(size.x(), size.y());
  EXPECT_NEAR(size.x(), 6, 0.001);
  EXPECT_NEAR(size.y(), 5, 0.001);
  EXPECT_NEAR((room.area.center - Eigen::Vector2d(3, 2.5)).norm(), 0, 0.001);
}

// An alcove of half a wall adds to the outline; a step that takes a quarter of the rectangle makes an L.
TEST(FindPlaces, AnAlcoveAndAnLMakeAHall) {
  for (const Polygon2d& outline : {Polygon2d{{0, 0}, {2, 0}, {2, -1.5}, {4, -1.5}, {4, 0}, {6, 0}, {6, 5}, {0, 5}},
                                   Polygon2d{{0, 0}, {3, 0}, {3, 2.5}, {6, 2.5}, {6, 5}, {0, 5}}}) {
    ScannedPlan scanned;
    scanned.face(outline);
    scanned.walk({{1, 1}, {2.5, 1}, {2.5, 4}, {5, 4}, {5, 3.5}, {1, 4}});
    const FoundPlaces found = found_in(scanned);
    ASSERT_EQ(found.places.size(), 1U);
    EXPECT_EQ(found.places[0].kind, PlaceKind::hall);
  }
}

// Two rows that leave an aisle of 3 m between them, openings of which are far less than half as wide as the hall.
FoundPlaces found_between_rows(double height) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {24, 0}, {24, 14}, {0, 14}});
  scanned.box({4, 3}, {20, 5}, height);
  scanned.box({4, 8}, {20, 10}, height);
  scanned.walk({{2, 1.5}, {22, 1.5}, {22, 6.5}, {2, 6.5}, {2, 12}, {22, 12}});
  return found_in(scanned);
}

TEST(FindPlaces, RowsThatDoNotReachTheCeilingStandWithinOnePlace) {
  const FoundPlaces found = found_between_rows(1.6);
  ASSERT_EQ(found.places.size(), 1U);
  EXPECT_EQ(found.places[0].kind, PlaceKind::room);
  EXPECT_NEAR(area(found.places[0].outline), 24 * 14, 1e-6);
  EXPECT_TRUE(found.doors.empty());
}

TEST(FindPlaces, RowsThatReachTheCeilingPartTheFloor) {
  const FoundPlaces found = found_between_rows(100);
  EXPECT_GT(found.places.size(), 1U);
  for (const FoundPlace& place : found.places) EXPECT_LT(area(place.outline), 24 * 14 - 4 * 16 + 1);
}

TEST(FindPlaces, AnOfficeThatDoesNotReachTheHallsCeilingIsARoom) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {24, 0}, {24, 14}, {0, 14}});
  const std::size_t first = scanned.plan.walls.size();
  scanned.wall({9, 5}, {14, 5}, {{2, 2.9}});
  scanned.wall({14, 5}, {14, 9});
  scanned.wall({14, 9}, {9, 9});
  scanned.wall({9, 9}, {9, 5});
  for (std::size_t i = first; i < scanned.plan.walls.size(); ++i) scanned.heights[i] = 1.6;
  scanned.walk({{2, 2}, {22, 2}, {22, 12}, {2, 12}, {2, 3}, {11.45, 3}, {11.45, 7}, {13, 7}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 2U);
  ASSERT_EQ(found.doors.size(), 1U);
  EXPECT_NEAR(area(found.places[0].outline) + area(found.places[1].outline), 24 * 14 - 5.15 * 4.15 + 4.85 * 3.85, 0.05);
}

TEST(FindPlaces, ARackAtAWallIsPartOfTheRoomHoweverDeepAndLong) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {14, 0}, {14, 10}, {0, 10}});
  scanned.box({0.02, 0.02}, {5, 1.4}, 1.6);  // deeper than what the length and depth of furniture allow, in a corner
  scanned.walk({{2, 3}, {12, 3}, {12, 8}, {2, 8}, {2, 4}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 1U);
  EXPECT_EQ(found.places[0].kind, PlaceKind::room);
  EXPECT_NEAR(area(found.places[0].outline), 140, 1e-6);
}

TEST(FindPlaces, AGapBesideFurnitureIsNoDoor) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {14, 0}, {14, 10}, {0, 10}});
  scanned.wall({4, 0}, {4, 3});
  scanned.box({0.02, 1.2}, {3.1, 1.3}, 1.6);  // a counter; the floor behind it is seen through the gap that it leaves
  scanned.walk({{2, 3}, {12, 3}, {12, 8}, {2, 8}, {2, 4}, {3.5, 2.5}});
  const FoundPlaces found = found_in(scanned);
  EXPECT_EQ(found.places.size(), 1U);
  EXPECT_TRUE(found.doors.empty());
}

TEST(FindPlaces, APassageBesideWhatRaysPassIsNoDoor) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {10, 0}, {10, 8}, {0, 8}});
  scanned.box({4, 3}, {6, 5}, 100);  // a shaft, and a scaffold whose fronts are in line with its own: rays pass between the posts
  const std::vector<Interval> between_posts{{0.25, 0.45}, {0.7, 0.9}, {1.15, 1.35}, {1.6, 1.8}};
  scanned.plan.add({7.6, 3}, {7.6, 5}, between_posts);
  scanned.plan.add({7.6, 5}, {10, 5}, between_posts);
  scanned.plan.add({10, 3}, {7.6, 3}, between_posts);
  scanned.walk({{2, 2}, {2, 6}, {6.8, 6.5}, {6.8, 1.5}, {2, 1.5}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 1U);
  EXPECT_TRUE(found.doors.empty());
}

TEST(FindPlaces, AGapBetweenCupboardsIsNoDoorThroughTheWallBehind) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {10, 0}, {10, 8}, {0, 8}});
  scanned.wall({0, 4}, {10, 4}, {{8.6, 9.6}});
  scanned.box({0.1, 4.08}, {3.0, 4.6}, 100);
  scanned.box({4.2, 4.08}, {7.6, 4.6}, 100);
  scanned.walk({{2, 2}, {9.1, 2}, {9.1, 6}, {2, 6}, {3.6, 5.2}, {5, 6}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 2U);
  ASSERT_EQ(found.doors.size(), 1U);
  EXPECT_NEAR(found.doors[0].position.x(), 9.1, 0.1);
}

TEST(FindPlaces, ADoorBesideTheEndOfACorridorMakesItNoWider) {
  ScannedPlan scanned;
  scanned.face({{0, 8}, {8, 8}, {8, 0}, {9.85, 0}, {9.85, 8}, {18, 8}, {18, 9.72}, {0, 9.72}}, {{}, {}, {}, {}, {}, {}, {{10.1, 11.2}}});
  scanned.face({{0, 9.9}, {18, 9.9}, {18, 15}, {0, 15}}, {{{6.8, 7.9}}});
  scanned.walk({{1, 9}, {17, 9}, {9, 9}, {9, 1}, {9, 9}, {7.35, 9}, {7.35, 12}, {2, 12}, {16, 12}});
  const FoundPlaces found = found_in(scanned);
  EXPECT_EQ(found.places.size(), 3U);
  EXPECT_EQ(found.branchings.size(), 1U);
  EXPECT_EQ(found.doors.size(), 1U);
}

TEST(FindPlaces, FacesThatSwingALittleAreOneWall) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {12, 0}, {12, 4}, {0, 4}});
  scanned.plan.add({3, 0.075}, {9, 0.11});  // the same wall, known less well
  scanned.walk({{1, 2}, {11, 2}});
  const std::vector<WallLine> lines = find_wall_lines(scanned.plan.walls, scanned.space, scanned.path, PlaceParams{});
  EXPECT_EQ(lines.size(), 4U);
}

TEST(FindPlaces, ARowOfColumnsUnderABeamPartsNothing) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {24, 0}, {24, 14}, {0, 14}});
  for (const double y : {3.5, 7.0, 10.5}) scanned.box({11.8, y - 0.2}, {12.2, y + 0.2}, 100);
  for (const bool left : {true, false}) {  // the beam's sides, in line with the columns' faces
    scanned.undersides[scanned.plan.walls.size()] = 1.9;
    scanned.plan.add({left ? 11.8 : 12.2, left ? 14.0 : 0.0}, {left ? 11.8 : 12.2, left ? 0.0 : 14.0});
  }
  scanned.walk({{3, 3}, {3, 11}, {9, 9}, {15, 9}, {20, 11}, {20, 3}, {15, 5}, {9, 5}});
  int wide = 0;
  for (const WallLine& line : find_wall_lines(scanned.plan.walls, scanned.space, scanned.path, PlaceParams{})) {
    for (const Gap& gap : line.gaps) {
      if (gap.along.length() < 2.5 || !gap.low_jamb || !gap.high_jamb) continue;
      ++wide;
      EXPECT_FALSE(gap.cut);
    }
  }
  EXPECT_GE(wide, 2);
  EXPECT_EQ(found_in(scanned).places.size(), 1U);
}

TEST(FindPlaces, AGapInALowRowBeforeABayIsNoDoor) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {8, 0}, {8, 13}, {0, 13}});
  scanned.box({0, 4.0}, {3.5, 4.2}, 1.45);  // as low as parked cars, whose bay the robot doesn't enter
  scanned.box({4.4, 4.0}, {8, 4.2}, 1.45);
  scanned.walk({{2, 7}, {6, 7}, {6, 12}, {2, 12}});
  const FoundPlaces found = found_in(scanned);
  EXPECT_EQ(found.places.size(), 1U);
  EXPECT_TRUE(found.doors.empty());
}

TEST(FindPlaces, AWallUnderAWindowIsNoFurniture) {
  ScannedPlan scanned;
  scanned.plan.add({10, 0}, {10, 10});
  scanned.plan.add({10, 10}, {0, 10});
  scanned.plan.add({0, 10}, {0, 0});
  scanned.heights[scanned.plan.walls.size()] = 0.9;
  scanned.plan.add({0, 0}, {10, 0});          // the wall to the sill,
  scanned.plan.add({0, -0.15}, {10, -0.15});  // and the pane behind it
  scanned.walk({{2, 2}, {8, 2}, {8, 9}, {2, 9}, {2, 2}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 1U);
  EXPECT_NEAR(found.places[0].area.area(), 100, 1e-6);
}

TEST(FindPlaces, StrayHitsInACorridorMakeNoWall) {
  ScannedPlan scanned;
  scanned.stray = 7;
  scanned.face({{0, 0}, {12, 0}, {12, 2}, {0, 2}});
  scanned.plan.add({6, 2.15}, {6, 6});  // of the rooms beside it; its line is followed into the corridor
  std::vector<Eigen::Vector2d> rounds;
  for (int i = 0; i < 12; ++i) rounds.emplace_back(i % 2 == 0 ? 1 : 11, 1);
  scanned.walk(rounds);
  PlaceParams params;
  params.robot_radius = 0.3;  // its way is as wide as a door
  const FoundPlaces found = find_places(scanned.space, scanned.plan.walls, scanned.path, 0, params);
  ASSERT_EQ(found.places.size(), 1U);
  EXPECT_NEAR(found.places[0].area.size.x(), 12, 1e-6);
}

TEST(FindPlaces, APaneWithinTheThicknessOfAWallIsNoDoor) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {10, 0}, {10, 6}, {0, 6}});
  const std::vector<Interval> holes{{0.6, 2.0}, {4.0, 4.9}};  // the pane, and a door
  scanned.plan.add({4.85, 0}, {4.85, 6}, holes);
  scanned.plan.add({5.15, 6}, {5.15, 0}, {{1.1, 2.0}, {4.0, 5.4}});
  const std::vector<Wall> without_pane = scanned.plan.walls;
  for (const bool back : {false, true}) {
    scanned.panes.insert(scanned.plan.walls.size());
    scanned.plan.add({5, back ? 2.0 : 0.6}, {5, back ? 0.6 : 2.0});
  }
  scanned.walk({{2, 5}, {2, 0.5}, {3.5, 0.5}, {3.5, 4.45}, {6.5, 4.45}, {6.5, 0.5}, {8, 0.5}, {8, 5}});
  const FoundPlaces found = find_places(scanned.space, without_pane, scanned.path, 0, PlaceParams{});
  EXPECT_EQ(found.places.size(), 2U);
  ASSERT_EQ(found.doors.size(), 1U);
  EXPECT_NEAR(found.doors[0].position.y(), 4.45, 0.1);
}

TEST(FindPlaces, ADoorInAPaneIsAsWideAsWhereThePaneEnds) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {10, 0}, {10, 10}, {0, 10}});
  const std::size_t first = scanned.plan.walls.size();
  scanned.plan.add({0, 6}, {10, 6}, {{6, 7}});
  scanned.plan.add({10, 6}, {0, 6}, {{3, 4}});
  scanned.panes = {first, first + 1};
  scanned.walk({{0.3, 4.5}, {9.7, 4.5}, {0.3, 4.5}, {6.5, 4.5}, {6.5, 8}, {0.3, 8}, {9.7, 8}});
  FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 2U);
  ASSERT_EQ(found.doors.size(), 1U);
  measure_door(scanned.space, found.doors[0]);
  EXPECT_NEAR(found.doors[0].width, 1.0, 0.05);
  EXPECT_NEAR(found.doors[0].position.x(), 6.5, 0.05);
}

TEST(FindPlaces, AFewHitsInAnOpenDoorAreNoPane) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {12, 0}, {12, 2}, {0, 2}}, {{}, {}, {{5, 6}}});
  scanned.face({{0, 2.15}, {12, 2.15}, {12, 6}, {0, 6}}, {{{6, 7}}});
  scanned.closed_until = 2;  // shut at first: two keyframes saw its leaf
  scanned.door = scanned.plan.walls.size();
  scanned.plan.add({7, 2}, {6, 2});
  const std::vector<Wall> walls(scanned.plan.walls.begin(), scanned.plan.walls.end() - 1);
  std::vector<Eigen::Vector2d> rounds{{6.5, 1}, {6.4, 1}};
  for (int i = 0; i < 8; ++i) rounds.emplace_back(i % 2 == 0 ? 1 : 11, 1);
  scanned.walk(rounds);
  const FoundPlaces found = find_places(scanned.space, walls, scanned.path, 0, PlaceParams{});
  EXPECT_EQ(found.places.size(), 1U);
  EXPECT_EQ(found.doors.size(), 1U);
}

TEST(FindPlaces, WhatTheRobotHasNotEnteredIsNoPlace) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {10, 0}, {10, 4}, {0, 4}});
  scanned.wall({5, 0}, {5, 4}, {{1.5, 2.4}});
  scanned.walk({{1, 1}, {4, 1.95}, {2, 3}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 1U);
  ASSERT_EQ(found.doors.size(), 1U);  // which leads out of the known places
  EXPECT_EQ(found.doors[0].places, (std::array<std::size_t, 2>{0, FoundDoor::nowhere}));
}

TEST(FindPlaces, ACupboardInACorridorMakesNoDoor) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {12, 0}, {12, 2}, {0, 2}});
  scanned.plan.add({6, 1.5}, {6, 2});  // its side, in line with a wall between the rooms beside the corridor
  scanned.plan.add({6, 2.15}, {6, 6});
  scanned.plan.add({6.5, 2}, {6.5, 1.5});
  scanned.plan.add({6.5, 1.5}, {6, 1.5});
  scanned.walk({{1, 0.8}, {11, 0.8}});
  const FoundPlaces found = found_in(scanned);
  ASSERT_EQ(found.places.size(), 1U);
  EXPECT_EQ(found.places[0].kind, PlaceKind::corridor);
  EXPECT_NEAR(found.places[0].area.size.x(), 12, 1e-6);
  EXPECT_TRUE(found.doors.empty());
}

}  // namespace
}  // namespace sgraph
