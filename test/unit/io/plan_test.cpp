#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "sgraph_slam/core/io/floor_plan.hpp"
#include "sgraph_slam/core/io/occupancy_grid.hpp"
#include "small_room.hpp"

namespace sgraph {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr double yaws[] = {0.0, 0.35, -1.2};

OccupancyGrid grid_of(const SmallRoom& room) { return make_occupancy_grid(room.snapshot, room.T_base_lidar(), OutputParams()); }

TEST(OccupancyGrid, WallsAreOccupiedTheRoomIsFreeBehindIsUnknown) {
  for (const double yaw : yaws) {
    const SmallRoom room(yaw);
    const OccupancyGrid grid = grid_of(room);
    int occupied = 0;
    for (double s = -1.9; s < 1.9; s += 0.05) {
      for (const double side : {-1.0, 1.0}) {
        if (side > 0 && s > 0.4 && s < 1.6) continue;  // the door
        occupied += grid.at(room.at(side * 3.01, s)) == OccupancyGrid::occupied || grid.at(room.at(side * 2.99, s)) == OccupancyGrid::occupied;
      }
    }
    EXPECT_GT(occupied, 110) << yaw;  // of 130
    for (double x = -2.8; x < 2.8; x += 0.1) {
      for (double y = -1.8; y < 1.8; y += 0.1) EXPECT_EQ(grid.at(room.at(x, y)), OccupancyGrid::free) << yaw << ' ' << x << ' ' << y;
    }
    EXPECT_EQ(grid.at(room.at(0, 2.3)), OccupancyGrid::unknown);
    EXPECT_EQ(grid.at(room.at(-3.3, 0)), OccupancyGrid::unknown);
    EXPECT_EQ(grid.at(room.at(3, 1)), OccupancyGrid::free);        // the door
    EXPECT_EQ(grid.at(room.at(4, 1.6)), OccupancyGrid::free);      // seen through it
    EXPECT_EQ(grid.at(room.at(4, 0.2)), OccupancyGrid::unknown);   // hidden by the wall beside it
    EXPECT_EQ(grid.at(room.at(1000, 0)), OccupancyGrid::unknown);  // outside
  }
}

TEST(OccupancyGrid, OnlyWhatIsInTheBandIsAnObstacle) {
  SmallRoom room;
  Cloud cloud = *room.snapshot.keyframes.at({0}).cloud.get();
  const auto add = [&cloud](double x, double y, double z) {
    Point p;
    p.x = static_cast<float>(x);
    p.y = static_cast<float>(y + 1);  // seen from the LiDAR at (0, -1, 1)
    p.z = static_cast<float>(z - 1);
    cloud.points.push_back(p);
  };
  add(-2.02, 1.02, 0.1);  // a doorstep
  add(-1.02, 1.02, 2.2);  // a lamp
  add(1.02, 1.02, 0.5);   // a box
  room.snapshot.keyframes.at({0}).cloud = std::make_shared<Cloud>(cloud);
  const OccupancyGrid grid = grid_of(room);
  EXPECT_EQ(grid.at({-2.02, 1.02}), OccupancyGrid::free);
  EXPECT_EQ(grid.at({-1.02, 1.02}), OccupancyGrid::free);
  EXPECT_EQ(grid.at({1.02, 1.02}), OccupancyGrid::occupied);
}

TEST(OccupancyGrid, WhatMovedAwayIsFreeAgain) {
  SmallRoom room;
  const SceneKeyframe first = room.snapshot.keyframes.at({0});
  auto with_visitor = std::make_shared<Cloud>(*first.cloud.get());
  Point p;
  p.x = 1.02F;
  p.y = 1.02F;
  with_visitor->points.push_back(p);
  room.snapshot.keyframes.at({0}).cloud = with_visitor;
  EXPECT_EQ(grid_of(room).at({1.02, 0.02}), OccupancyGrid::occupied);
  for (std::int64_t i = 1; i < 6; ++i) {
    SceneKeyframe later = first;
    later.id = {i};
    room.snapshot.keyframes.emplace(later.id, later);
    room.snapshot.planes.at({0}).keyframes.insert(later.id);
  }
  EXPECT_EQ(grid_of(room).at({1.02, 0.02}), OccupancyGrid::free);
}

TEST(OccupancyGrid, AFarReflectionDoesNotEatTheMemory) {
  SmallRoom room;
  auto cloud = std::make_shared<Cloud>(*room.snapshot.keyframes.at({0}).cloud.get());
  Point p;
  p.x = 9e4F;
  p.y = 9e4F;
  cloud->points.push_back(p);
  p.x = 3e30F;
  cloud->points.push_back(p);
  room.snapshot.keyframes.at({0}).cloud = cloud;
  const OccupancyGrid grid = grid_of(room);
  EXPECT_LE(grid.cells.size(), 100'000'000U);
  EXPECT_GT(grid.resolution, 1);
}

TEST(OccupancyGrid, AnEmptyMapGivesAnEmptyGrid) {
  const OccupancyGrid grid = make_occupancy_grid(GraphSnapshot(), Pose(), OutputParams());
  EXPECT_TRUE(grid.cells.empty());
  EXPECT_EQ(grid.at({0, 0}), OccupancyGrid::unknown);
  EXPECT_EQ(pgm_bytes(grid), "P5\n0 0\n255\n");
}

TEST(OccupancyGrid, FilesFollowMapServer) {
  OccupancyGrid grid;
  grid.resolution = 0.1;
  grid.origin = {-1.5, 2};
  grid.width = 3;
  grid.height = 2;
  grid.cells = {0, 100, -1, -1, -1, 100};
  EXPECT_EQ(pgm_bytes(grid), "P5\n3 2\n255\n\xCD\xCD" + std::string("\0\xFE", 2) + std::string("\0\xCD", 2));
  EXPECT_EQ(map_yaml(grid, "map.pgm"),
            "image: map.pgm\nresolution: 0.1\norigin: [-1.5, 2, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n");
}

TEST(FloorPlan, WallsHaveTheirExtentAndTheirDoor) {
  for (const double yaw : yaws) {
    const SmallRoom room(yaw);
    const FloorPlan plan = make_floor_plan(room.snapshot, grid_of(room), {});
    ASSERT_EQ(plan.walls.size(), 4U);  // the floor is none
    double lengths[4];
    for (std::size_t i = 0; i < 4; ++i) lengths[i] = (plan.walls[i].line.second - plan.walls[i].line.first).norm();
    EXPECT_NEAR(lengths[0], 4, 1e-9);
    EXPECT_NEAR(lengths[3], 6, 1e-9);
    EXPECT_EQ(plan.walls[0].solid.size(), 1U) << yaw;
    EXPECT_EQ(plan.walls[2].solid.size(), 1U) << yaw;
    ASSERT_EQ(plan.walls[1].solid.size(), 2U) << yaw;
    const auto& solid = plan.walls[1].solid;
    EXPECT_NEAR((solid[1].first - solid[0].second).norm(), 1.0, 0.2) << yaw;  // the door, to a few cells
    EXPECT_FALSE(plan.walls[1].low);
    EXPECT_NEAR(std::remainder(plan.yaw - yaw, M_PI_2), 0, 1e-12);
    EXPECT_LE(std::abs(plan.yaw), M_PI_4);
  }
}

TEST(FloorPlan, PlacesAreWhereTheyAre) {
  SmallRoom room(0.35);
  SceneCorridor corridor;
  corridor.id = {4};
  corridor.center = {10, 0, 1};
  corridor.width = 2;
  corridor.length = 8;
  corridor.yaw = M_PI_2;
  room.snapshot.corridors.emplace(corridor.id, corridor);
  const FloorPlan plan = make_floor_plan(room.snapshot, grid_of(room), {});
  ASSERT_EQ(plan.places.size(), 2U);
  EXPECT_EQ(plan.places[0].name, "Corridor 4");
  EXPECT_LT((plan.places[0].outline[0] - Eigen::Vector2d(11, -4)).norm(), 1e-9);  // its own -x, -y
  EXPECT_EQ(plan.places[1].name, "Room 7");
  EXPECT_LT((plan.places[1].outline[2] - room.at(3, 2)).norm(), 1e-9);
}

TEST(FloorPlan, FurnitureIsLowAndWithoutCloudsWallsAreWhole) {
  SmallRoom room;
  for (auto& [id, keyframe] : room.snapshot.keyframes) keyframe.cloud = nullptr;
  ScenePlane cabinet = room.snapshot.planes.at({1});
  cabinet.id = {11};
  for (auto& corner : cabinet.extent) corner.z() *= 0.3;
  room.snapshot.planes.emplace(cabinet.id, cabinet);
  const FloorPlan plan = make_floor_plan(room.snapshot, grid_of(room), {});
  ASSERT_EQ(plan.walls.size(), 5U);
  EXPECT_TRUE(plan.walls[4].low);
  for (const DrawnWall& wall : plan.walls) {
    ASSERT_EQ(wall.solid.size(), 1U);
    EXPECT_EQ(wall.solid[0], wall.line);
  }
}

int big_endian(const std::string& bytes, std::size_t at) {
  int value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

TEST(FloorPlan, IsDrawnAtALegibleSize) {
  const SmallRoom room(0.35);
  const Trajectory path{{{1}, Pose()}, {{2}, Pose{Eigen::Quaterniond::Identity(), {1, 1, 0}}}};
  const FloorPlan plan = make_floor_plan(room.snapshot, grid_of(room), path);
  const std::string png = floor_plan_png(plan);
  EXPECT_THAT(png, StartsWith("\x89PNG"));
  EXPECT_EQ(std::max(big_endian(png, 16), big_endian(png, 20)), 1600);
  const std::string svg = floor_plan_svg(plan);
  for (const char* words : {"<svg ", "Room 7", "6.00 x 4.00 m", "1 room, 0 corridors, path 1.4 m", "2 m", "</svg>"})
    EXPECT_THAT(svg, HasSubstr(words));
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(FloorPlan, RoomsOfAnyOutlineAndDoorsAreDrawn) {
  SmallRoom room;
  SceneRoom hall;
  hall.id = {8};
  hall.center = {1, 1, 1};
  hall.polygon = {{0, 0}, {5, 0}, {5, 2}, {2, 2}, {2, 4}, {0, 4}};
  room.snapshot.rooms[hall.id] = hall;
  room.snapshot.doors[{3}] = {{3}, "room/7", "room/8", {3, 1, 0}, 0, 0.95, 2.1, 0};
  const FloorPlan plan = make_floor_plan(room.snapshot, grid_of(room), {});
  EXPECT_NEAR(plan.places.back().area, 14, 1e-9);
  const std::string svg = floor_plan_svg(plan);
  for (const char* words : {"Room 8", "14.00 m2", "1 door,"}) EXPECT_THAT(svg, HasSubstr(words));
}

TEST(FloorPlan, IsWrittenForCad) {
  SmallRoom room;
  room.snapshot.doors[{3}] = {{3}, "room/7", "room/8", {3, 1, 0}, 0, 0.95, 2.1, 0};
  const std::string dxf = floor_plan_dxf(make_floor_plan(room.snapshot, grid_of(room), {}));
  for (const char* words : {"AC1009", "WALLS", "INSIDE", "DOORS", "PLACES", "Room 7", "24.00 m2, 6.00 x 4.00 m", "0\nENDSEC\n0\nEOF\n"})
    EXPECT_THAT(dxf, HasSubstr(words));
  // Codes and values take turns, a line each.
  std::istringstream lines(dxf);
  std::string code;
  std::string value;
  while (std::getline(lines, code)) {
    ASSERT_TRUE(std::getline(lines, value));
    EXPECT_NO_THROW(static_cast<void>(std::stoi(code))) << code;
  }
  EXPECT_EQ(value, "EOF");
}

TEST(FloorPlan, OfNothingIsStillAPicture) {
  const FloorPlan plan = make_floor_plan(GraphSnapshot(), OccupancyGrid(), {});
  EXPECT_THAT(floor_plan_png(plan), StartsWith("\x89PNG"));
  EXPECT_THAT(floor_plan_svg(plan), HasSubstr("0 rooms, 0 corridors"));
}

}  // namespace
}  // namespace sgraph
