#include "sgraph_slam/core/planes/level_floors.hpp"

#include <gtest/gtest.h>

#include "sgraph_slam/core/graph/solver.hpp"
#include "two_floors.hpp"

namespace sgraph {
namespace {

// Between the two a lift, on which the tilt came to be wrong.
TwoFloors tilted_storey(double tilt) {
  Vector6 link = Vector6::Constant(0.001);
  link.head<2>().setConstant(0.035);
  return TwoFloors({Eigen::Quaterniond(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX())), Eigen::Vector3d::Zero()}, link, 1);
}

TEST(LevelFloors, AStoreyThatALiftLedToStandsUpright) {
  TwoFloors building = tilted_storey(0.03);
  EXPECT_EQ(level_floors(building.committer, building.planes, {}), 0);  // by stairs: so steep a floor is meant to slope
  EXPECT_EQ(level_floors(building.committer, building.planes, {1}), 1);
  EXPECT_EQ(level_floors(building.committer, building.planes, {1}), 0);  // once
  solve(building.graph, {});
  EXPECT_LT(building.tilt(), 0.002);
  const Pose& up = *building.graph.find(KeyframeId{5});
  EXPECT_NEAR((up.rotation * Eigen::Vector3d::UnitZ()).z(), 1, 1e-5);
  EXPECT_NEAR(up.translation.x(), 2.5, 0.01);
}

TEST(LevelFloors, AStoreyThatStairsLedToIsLevelWithTheFirst) {
  TwoFloors building = tilted_storey(0.006);
  EXPECT_EQ(level_floors(building.committer, building.planes, {}), 1);
  solve(building.graph, {});
  EXPECT_LT(building.tilt(), 0.001);
}

}  // namespace
}  // namespace sgraph
