#include "sgraph_slam/core/planes/level_floors.hpp"

#include <gtest/gtest.h>

#include "sgraph_slam/core/graph/solver.hpp"

namespace sgraph {
namespace {

// Two storeys of three keyframes each, every one of which sees its floor. Between them a lift, on which the tilt came to be wrong.
struct TwoStoreys {
  explicit TwoStoreys(double tilt) {
    const Eigen::Quaterniond tilted(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()));
    const Outline floor{{-3, -3, -0.5}, {3, -3, -0.5}, {3, 3, -0.5}, {-3, 3, -0.5}};
    const Plane seen{Eigen::Vector3d::UnitZ(), 0.5};
    for (std::int64_t k = 0; k < 6; ++k) {
      const KeyframeId id{k};
      const PlaneId plane{k / 3};
      const Pose pose{k < 3 ? Eigen::Quaterniond::Identity() : tilted, {0.5 * static_cast<double>(k), 0, 0}};
      Transaction edit;
      edit.keyframes[id] = pose;
      if (k % 3 == 0) edit.planes[plane] = pose * seen;
      if (k > 0) {
        const Pose& before = *graph.find(KeyframeId{k - 1});
        Vector6 sigma = Vector6::Constant(0.001);
        if (k == 3) sigma.head<2>().setConstant(0.035);
        add_factor(edit, Se3Between{{k - 1}, id, before.inverse() * pose, SqrtInformation<6>::from_std_dev(sigma)});
      }
      add_factor(edit, PosePlane{id, plane, seen, {}, SqrtInformation<3>::from_std_dev({0.003, 0.003, 0.006})});
      const Applied applied = committer.commit(edit);
      EXPECT_TRUE(applied.ok()) << applied.detail;
      planes.observe(graph, plane, id, applied.factors.back(), floor, {}, seen, 1e-5 * Eigen::Matrix3d::Identity());
      planes.reclassify(graph, plane, {});
      if (k % 3 == 0) planes.set_storey(plane, static_cast<int>(plane.value));
    }
  }

  double tilt() const { return std::acos(graph.find(PlaneId{0})->normal.dot(graph.find(PlaneId{1})->normal)); }

  Graph graph;
  DecisionLog log;
  Committer committer{graph, log};
  PlaneMap planes{SemanticsParams{}};
};

TEST(LevelFloors, AStoreyThatALiftLedToStandsUpright) {
  TwoStoreys building(0.03);
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
  TwoStoreys building(0.006);
  EXPECT_EQ(level_floors(building.committer, building.planes, {}), 1);
  solve(building.graph, {});
  EXPECT_LT(building.tilt(), 0.001);
}

}  // namespace
}  // namespace sgraph
