#include "sgraph_slam/core/planes/tie_stairwells.hpp"

#include <gtest/gtest.h>

#include "sgraph_slam/core/graph/solver.hpp"
#include "sgraph_slam/core/types/storey.hpp"
#include "two_floors.hpp"

namespace sgraph {
namespace {

// The storey's floor as it is seen from the stairs: `above` the other and tilted against it. Where one led to the other the odometry knew neither
// tilt nor height.
TwoFloors from_the_stairs(double above, double tilt = 0.006, double aside = 0) {
  Vector6 link;
  link << 0.01, 0.01, 0.001, 0.01, 0.01, 0.1;
  return TwoFloors({Eigen::Quaterniond(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX())), {0, 0, above}}, link, stairwell, aside);
}

int tied_at(double above, double tilt = 0.006, double aside = 0) {
  TwoFloors building = from_the_stairs(above, tilt, aside);
  return tie_stairwells(building.committer, building.planes);
}

TEST(TieStairwells, OneFloorIsOneSurface) {
  TwoFloors building = from_the_stairs(0.04);
  EXPECT_EQ(tie_stairwells(building.committer, building.planes), 1);
  EXPECT_EQ(tie_stairwells(building.committer, building.planes), 0);  // once
  solve(building.graph, {});
  EXPECT_LT(building.tilt(), 0.001);
  EXPECT_LT(std::abs(building.step()), 0.004);
}

TEST(TieStairwells, AStepASlopeAndTheFloorNextDoorAreOthers) {
  EXPECT_EQ(tied_at(0.17), 0);
  EXPECT_EQ(tied_at(-0.17), 0);
  EXPECT_EQ(tied_at(0.02, 0.05), 0);
  EXPECT_EQ(tied_at(0.02, 0.006, 9), 0);
}

}  // namespace
}  // namespace sgraph
