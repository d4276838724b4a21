#include "sgraph_slam/core/eval/map_error.hpp"

#include <gtest/gtest.h>

#include <random>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

// One wall of 0.2 m along x from 0 to 10, 3 m high, with a door, a window with a pane; floor and ceiling under and over it.
Plan one_wall() {
  Plan plan;
  PlanWall wall;
  wall.q = {10, 0};
  wall.thickness = 0.2;
  wall.height = 3;
  wall.openings = {{2, 3, 0, 2.1, false}, {6, 8, 1, 2, true}};
  plan.walls.push_back(wall);
  PlanLevel level;
  level.ceiling = 3;
  level.ceiling_known = true;
  level.outline = {{-5, -5}, {15, -5}, {15, 5}, {-5, 5}};
  plan.levels.push_back(level);
  return plan;
}

void expect_nearest(const PlanSurfaces& surfaces, const Eigen::Vector3d& p, PlanSurface surface, double distance) {
  const SurfaceDistance found = surfaces.nearest(p);
  EXPECT_EQ(to_string(found.surface), std::string(to_string(surface))) << p.transpose();
  EXPECT_NEAR(found.distance, distance, 1e-9) << p.transpose();
}

TEST(PlanSurfaces, BothFacesOfAWallCountFromInsideAndOutside) {
  const PlanSurfaces surfaces(one_wall(), 0.5);
  expect_nearest(surfaces, {1, 0.13, 1.5}, PlanSurface::wall, 0.03);
  expect_nearest(surfaces, {1, -0.13, 1.5}, PlanSurface::wall, 0.03);
  expect_nearest(surfaces, {1, 0.07, 1.5}, PlanSurface::wall, 0.03);  // within the wall
  expect_nearest(surfaces, {1, -0.07, 1.5}, PlanSurface::wall, 0.03);
  expect_nearest(surfaces, {-0.3, 0.5 - 1e-9, 1.5}, PlanSurface::wall, 0.5);  // off the end's corner
  expect_nearest(surfaces, {-0.3, 0.51, 1.5}, PlanSurface::none, 0.5);
  expect_nearest(surfaces, {-0.3, 0.1, 1.5}, PlanSurface::wall, 0.3);
  expect_nearest(surfaces, {1, 0.61, 1.5}, PlanSurface::none, 0.5);
}

TEST(PlanSurfaces, OpeningsHaveEdgesAndPanesGlass) {
  const PlanSurfaces surfaces(one_wall(), 0.5);
  expect_nearest(surfaces, {2.3, 0, 1}, PlanSurface::wall, 0.3);      // the door's jamb
  expect_nearest(surfaces, {2.5, 0.1, 1.9}, PlanSurface::wall, 0.2);  // its lintel
  expect_nearest(surfaces, {2.5, 0.1, 2.5}, PlanSurface::wall, 0);    // above it
  expect_nearest(surfaces, {7, 0.04, 1.5}, PlanSurface::wall, 0.04);  // the pane, along the middle
  expect_nearest(surfaces, {7, 0.1, 0.9}, PlanSurface::wall, 0);      // below the window
}

TEST(PlanSurfaces, FloorsAndCeilingsEndAtTheirOutline) {
  const PlanSurfaces surfaces(one_wall(), 0.5);
  expect_nearest(surfaces, {5, 3, -0.02}, PlanSurface::floor, 0.02);
  expect_nearest(surfaces, {5, 3, 2.9}, PlanSurface::ceiling, 0.1);
  expect_nearest(surfaces, {5, 6, 0}, PlanSurface::none, 0.5);
  Plan open = one_wall();
  open.levels[0].ceiling.reset();
  open.levels[0].has_floor = false;
  expect_nearest(PlanSurfaces(open, 0.5), {5, 3, 0}, PlanSurface::none, 0.5);
}

TEST(PlanSurfaces, ColumnsAndFurnitureTurned) {
  Plan plan = one_wall();
  plan.blocks.push_back({{5, 3, 1.5}, {0.4, 0.4, 3}, M_PI_4, false, false});
  plan.blocks.push_back({{-3, 3, 0.5}, {0.6, 0.6, 1}, 0, true, true});
  const PlanSurfaces surfaces(plan, 0.5);
  expect_nearest(surfaces, {5 + 0.2 * std::sqrt(2) + 0.1, 3, 1.5}, PlanSurface::column, 0.1);  // before its edge
  expect_nearest(surfaces, {-3, 3.45, 0.5}, PlanSurface::furniture, 0.15);
  expect_nearest(surfaces, {-3, 3, 1.2}, PlanSurface::furniture, 0.2);
}

// Against a search over all solids without the grid: the smallest of the distances to each wall alone.
TEST(PlanSurfaces, GridFindsWhatASearchOfAllFinds) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(-12, 12);
  Plan plan;
  for (int i = 0; i < 40; ++i) {
    PlanWall wall;
    wall.p = {place(random), place(random)};
    wall.q = {place(random), place(random)};
    wall.thickness = 0.05 + 0.01 * i;
    wall.height = 3;
    plan.walls.push_back(wall);
  }
  const PlanSurfaces all(plan, 0.7);
  std::vector<PlanSurfaces> alone;
  for (const PlanWall& wall : plan.walls) {
    Plan one;
    one.walls.push_back(wall);
    alone.emplace_back(one, 0.7);
  }
  int found = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p(place(random), place(random), 1.5);
    double least = 0.7;
    for (const PlanSurfaces& one : alone) least = std::min(least, one.nearest(p).distance);
    EXPECT_NEAR(all.nearest(p).distance, least, 1e-12);
    found += least < 0.7 ? 1 : 0;
  }
  EXPECT_GT(found, 500);
}

TEST(MapError, SortsPointsAndMeasuresThemAfterTheAlignment) {
  Plan plan = one_wall();
  plan.blocks.push_back({{-3, 3, 0.5}, {1, 1, 1}, 0, false, true});
  const std::vector<Eigen::Vector3d> points{{1, 0.13, 1.5}, {1, -0.14, 1.5}, {5, 3, 0.01}, {5, 3, 1.2}, {-3, 3, 1.02}, {40, 0, 1}};
  Pose T_truth_map = se3_exp((Vector6() << 0.1, -0.2, 2, 3, -4, 1).finished());
  std::vector<Eigen::Vector3f> moved;
  for (const Eigen::Vector3d& p : points) moved.push_back((T_truth_map.inverse() * p).cast<float>());
  const MapError error = map_error(moved, T_truth_map, plan, 0.5);
  EXPECT_EQ(error.points, 6);
  EXPECT_EQ(error.structure.count, 3);
  EXPECT_NEAR(error.structure.rmse, std::sqrt((9 + 16 + 1) / 3.0) * 0.01, 1e-5);
  EXPECT_EQ(error.walls.count, 2);
  EXPECT_NEAR(error.horizontal.rmse, 0.01, 1e-5);
  EXPECT_EQ(error.furniture.count, 1);
  EXPECT_EQ(error.beyond_cap, 2);
  EXPECT_EQ(error.unknown_height, 0);
}

// Where the truth lists no furniture, what stands in a room may be some; what is off every surface outside is a ghost all the same.
TEST(MapError, FurnitureThatTheTruthDoesNotListIsNoGhost) {
  Plan plan = one_wall();
  PlanPlace room;
  room.center = {5, 3};
  room.width = {4, 3};
  room.yaw = 0.1;
  plan.rooms.push_back(room);
  const std::vector<Eigen::Vector3f> points{{5, 3, 1.2F}, {1, 0.13F, 1.5F}, {-40, 0, 1}};
  EXPECT_NEAR(map_error(points, Pose{}, plan, 0.5).ghost_share, 2 / 3.0, 1e-9);
  plan.furniture_known = false;
  const MapError error = map_error(points, Pose{}, plan, 0.5);
  EXPECT_EQ(error.unknown_inside, 1);
  EXPECT_NEAR(error.ghost_share, 0.5, 1e-9);
}

TEST(MapError, AnUnknownCeilingIsLeftOut) {
  Plan plan = one_wall();
  plan.levels[0].ceiling.reset();
  plan.levels[0].ceiling_known = false;
  const MapError error = map_error({{5, 0.3f, 2.9f}, {5, 0.1f, 1.9f}}, Pose{}, plan, 0.5);
  EXPECT_EQ(error.unknown_height, 1);
  EXPECT_EQ(error.structure.count, 1);
  EXPECT_EQ(map_error({}, Pose{}, plan).structure.rmse, 0);
}

}  // namespace
}  // namespace sgraph
