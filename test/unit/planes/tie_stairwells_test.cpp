#include "sgraph_slam/core/planes/tie_stairwells.hpp"

#include <gtest/gtest.h>

#include "sgraph_slam/core/graph/solver.hpp"
#include "sgraph_slam/core/types/storey.hpp"

namespace sgraph {
namespace {

// Three keyframes on a storey and three on the stairs, which see the storey's floor as a plane of theirs, `above` the other and tilted against it.
// Where one led to the other the odometry knew neither tilt nor height.
struct FloorFromTheStairs {
  explicit FloorFromTheStairs(double above, double tilt = 0.006, double aside = 0) {
    const Pose off{Eigen::Quaterniond(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX())), {0, 0, above}};
    const Plane seen{Eigen::Vector3d::UnitZ(), 0.5};
    for (std::int64_t k = 0; k < 6; ++k) {
      const KeyframeId id{k};
      const PlaneId plane{k / 3};
      const double x = 0.5 * static_cast<double>(k);
      const Pose pose = k < 3 ? Pose{Eigen::Quaterniond::Identity(), {x, 0, 0}} : off * Pose{Eigen::Quaterniond::Identity(), {x, 0, 0}};
      const double shift = k < 3 ? 0 : aside;
      const Outline floor{{shift - 3, -3, -0.5}, {shift + 3, -3, -0.5}, {shift + 3, 3, -0.5}, {shift - 3, 3, -0.5}};
      Transaction edit;
      edit.keyframes[id] = pose;
      if (k % 3 == 0) edit.planes[plane] = pose * seen;
      if (k > 0) {
        const Pose& before = *graph.find(KeyframeId{k - 1});
        Vector6 sigma = Vector6::Constant(0.001);
        if (k == 3) sigma << 0.01, 0.01, 0.001, 0.01, 0.01, 0.1;
        add_factor(edit, Se3Between{{k - 1}, id, before.inverse() * pose, SqrtInformation<6>::from_std_dev(sigma)});
      }
      add_factor(edit, PosePlane{id, plane, seen, {}, SqrtInformation<3>::from_std_dev({0.003, 0.003, 0.006})});
      const Applied applied = committer.commit(edit);
      EXPECT_TRUE(applied.ok()) << applied.detail;
      planes.observe(graph, plane, id, applied.factors.back(), floor, {}, seen, 1e-5 * Eigen::Matrix3d::Identity());
      planes.reclassify(graph, plane, {});
      if (k % 3 == 0) planes.set_storey(plane, k == 0 ? 0 : stairwell);
    }
  }

  int tie() { return tie_stairwells(committer, planes); }
  double tilt() const { return std::acos(graph.find(PlaneId{0})->normal.dot(graph.find(PlaneId{1})->normal)); }
  double step() const { return graph.find(PlaneId{0})->d - graph.find(PlaneId{1})->d; }

  Graph graph;
  DecisionLog log;
  Committer committer{graph, log};
  PlaneMap planes{SemanticsParams{}};
};

TEST(TieStairwells, OneFloorIsOneSurface) {
  FloorFromTheStairs building(0.04);
  EXPECT_EQ(building.tie(), 1);
  EXPECT_EQ(building.tie(), 0);  // once
  solve(building.graph, {});
  EXPECT_LT(building.tilt(), 0.001);
  EXPECT_LT(std::abs(building.step()), 0.004);
}

TEST(TieStairwells, AStepASlopeAndTheFloorNextDoorAreOthers) {
  EXPECT_EQ(FloorFromTheStairs(0.17).tie(), 0);
  EXPECT_EQ(FloorFromTheStairs(-0.17).tie(), 0);
  EXPECT_EQ(FloorFromTheStairs(0.02, 0.05).tie(), 0);
  EXPECT_EQ(FloorFromTheStairs(0.02, 0.006, 9).tie(), 0);
}

}  // namespace
}  // namespace sgraph
