#include "sgraph_slam/core/planes/align_storeys.hpp"

#include <gtest/gtest.h>

#include "sgraph_slam/core/graph/solver.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

struct Side {
  Eigen::Vector2d from;
  Eigen::Vector2d to;  // what is free lies to the left
};

// A facade of 10 x 8 m.
std::vector<Side> facade() { return {{{0, 0}, {10, 0}}, {{10, 0}, {10, 8}}, {{10, 8}, {0, 8}}, {{0, 8}, {0, 0}}}; }
// Walls within it, on both sides; `shift` makes another plan of them.
std::vector<Side> partitions(double shift) {
  return {{{3 + shift, 0}, {3 + shift, 8}},        {{2.85 + shift, 8}, {2.85 + shift, 0}}, {{3, 4 + shift}, {10, 4 + shift}},
          {{10, 3.85 + shift}, {3, 3.85 + shift}}, {{6 + shift, 4}, {6 + shift, 8}},       {{5.85 + shift, 8}, {5.85 + shift, 4}}};
}

// Two storeys, each seen whole from three keyframes that stand at one place; the way between them came to be off by `error`.
class TwoStoreys {
 public:
  TwoStoreys(const std::vector<Side>& below, const std::vector<Side>& above, const Pose& error, bool by_lift = false) {
    for (std::int64_t k = 0; k < 6; ++k) {
      const bool up = k >= 3;
      const Pose truth{Eigen::Quaterniond::Identity(), {5, 3 + 0.1 * static_cast<double>(k), up ? 3.0 : 0.0}};
      Transaction edit;
      edit.keyframes[KeyframeId{k}] = up ? error * truth : truth;
      if (k > 0) {
        const Pose motion = graph.find(KeyframeId{k - 1})->inverse() * edit.keyframes[KeyframeId{k}];
        Vector6 sigma = Vector6::Constant(k == 3 ? 0.03 : 0.001);
        sigma.head<2>().setConstant(0.0005);  // floors hold the tilt
        if (by_lift && k == 3) sigma[5] = 10;
        add_factor(edit, Se3Between{{k - 1}, {k}, motion, SqrtInformation<6>::from_std_dev(sigma)});
      }
      EXPECT_TRUE(committer.commit(edit).ok());
      for (std::size_t i = 0; i < (up ? above : below).size(); ++i)
        see((up ? above : below)[i], by_lift && up ? 0.01 : 0, {k}, {static_cast<std::int64_t>(i) + (up ? 100 : 0)}, truth);
      const double low = truth.translation.z() - 0.5;
      see({Eigen::Vector3d::UnitZ(), -low}, {{0, 0, low}, {10, 0, low}, {10, 8, low}, {0, 8, low}}, {k}, {up ? 199 : 99}, truth);
    }
    planes.refresh(graph, {});
  }

  // How far the upper storey is off, in the plan and in heading.
  [[nodiscard]] double off() const { return (graph.find(KeyframeId{5})->translation - Eigen::Vector3d(5, 3.5, 3)).head<2>().norm(); }
  [[nodiscard]] double turned() const { return so3_log(graph.find(KeyframeId{5})->rotation).norm(); }
  [[nodiscard]] std::size_t aligned() const {
    std::size_t count = 0;
    for (const auto& [id, factor] : graph.factors()) count += std::holds_alternative<AlignedWalls>(factor.data) ? 1 : 0;
    return count;
  }

  Graph graph;
  DecisionLog log;
  Committer committer{graph, log};
  PlaneMap planes{SemanticsParams{}};

 private:
  void see(const Side& side, double lean, KeyframeId keyframe, PlaneId id, const Pose& truth) {
    const Eigen::Vector2d direction = (side.to - side.from).normalized();
    const Eigen::Vector3d normal = Eigen::Vector3d(-direction.y(), direction.x(), lean).normalized();
    const double low = truth.translation.z() - 0.5;
    const Eigen::Vector3d from(side.from.x(), side.from.y(), low);
    const Eigen::Vector3d to(side.to.x(), side.to.y(), low);
    const Eigen::Vector3d up(0, 0, 2.5);
    see(Plane{normal, -normal.dot(from + 0.5 * up)}, {from, to, to + up, from + up}, keyframe, id, truth);
  }

  void see(const Plane& plane, const Outline& outline, KeyframeId keyframe, PlaneId id, const Pose& truth) {
    const Plane seen = truth.inverse() * plane;
    Transaction edit;
    if (graph.find(id) == nullptr) edit.planes[id] = *graph.find(keyframe) * seen;
    add_factor(edit, PosePlane{keyframe, id, seen, {}, SqrtInformation<3>::from_std_dev({0.002, 0.002, 0.003})});
    const Applied applied = committer.commit(edit);
    ASSERT_TRUE(applied.ok()) << applied.detail;
    planes.observe(graph, id, keyframe, applied.factors.back(), moved_outline(truth.inverse(), outline), {}, seen,
                   1e-6 * Eigen::Matrix3d::Identity());
    planes.reclassify(graph, id, {});
    planes.set_storey(id, id.value >= 100 ? 1 : 0);
  }
};

std::vector<Side> joined(std::vector<Side> a, const std::vector<Side>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

const Pose drift{so3_exp(Eigen::Vector3d(0, 0, 0.005)), {0.05, -0.07, 0}};

TEST(AlignStoreys, WallsStandOnWalls) {
  const auto plan = joined(facade(), partitions(0));
  TwoStoreys building(plan, plan, drift);
  EXPECT_GT(building.off(), 0.03);
  EXPECT_EQ(align_storeys(building.committer, building.planes, {0, 0}), static_cast<int>(plan.size()));
  solve(building.graph, {});
  EXPECT_LT(building.off(), 0.003);
  EXPECT_LT(building.turned(), 0.0005);
  building.planes.refresh(building.graph, {});
  EXPECT_EQ(align_storeys(building.committer, building.planes, {0, 0}), 0);  // they are joined
}

// Its walls lean, and would tell a height by where they stand.
TEST(AlignStoreys, AStoreyOfUnknownHeightStaysWhereItIsDrawn) {
  const auto plan = joined(facade(), partitions(0));
  const Pose drawn{drift.rotation, drift.translation - Eigen::Vector3d(0, 0, 3)};  // beside the first storey
  TwoStoreys building(plan, plan, drawn, true);
  EXPECT_EQ(align_storeys(building.committer, building.planes, {0, 1}), static_cast<int>(plan.size()) + 1);
  EXPECT_EQ(align_storeys(building.committer, building.planes, {0, 1}), 0);
  solve(building.graph, {});
  EXPECT_LT(building.off(), 0.005);
  EXPECT_LT(building.turned(), 0.001);
  EXPECT_NEAR(building.graph.find(KeyframeId{5})->translation.z(), 0, 0.1);
  // Something tells the height.
  EXPECT_EQ(align_storeys(building.committer, building.planes, {0, 0}), 1);
  EXPECT_EQ(building.aligned(), plan.size());
}

TEST(AlignStoreys, PartitionsElsewhereJoinNothing) {
  // The upper storey's stand 20 cm beside the lower's: near enough to be asked, and wrong.
  TwoStoreys building(joined(facade(), partitions(0)), joined(facade(), partitions(0.2)), {});
  const int changes = align_storeys(building.committer, building.planes, {0, 0});
  solve(building.graph, {});
  EXPECT_LE(changes, 4);  // the facade, when it is enough to tell
  EXPECT_LT(building.off(), 0.001);
}

TEST(AlignStoreys, WhatAgreesByChanceIsNotJoined) {
  // Another plan on top, of which two walls happen to stand above others.
  const std::vector<Side> other{{{0.12, 0}, {0.12, 8}}, {{10, 0.2}, {0, 0.2}},  {{3.25, 0}, {3.25, 8}},
                                {{3, 4}, {10, 4}},      {{2.85, 8}, {2.85, 0}}, {{10, 3.6}, {3, 3.6}}};
  TwoStoreys building(joined(facade(), partitions(0)), other, {});
  EXPECT_EQ(align_storeys(building.committer, building.planes, {0, 0}), 0);
}

TEST(AlignStoreys, WallsOfOneDirectionSayNothingOfTheOther) {
  const std::vector<Side> hall{{{0, 0}, {10, 0}}, {{10, 8}, {0, 8}}, {{0, 4}, {10, 4}}, {{10, 3.85}, {0, 3.85}}, {{0, 6}, {10, 6}}};
  TwoStoreys building(hall, hall, drift);
  EXPECT_EQ(align_storeys(building.committer, building.planes, {0, 0}), 0);
}

TEST(AlignStoreys, AJoinThatNoLongerAgreesIsTakenBack) {
  const auto plan = joined(facade(), partitions(0));
  TwoStoreys building(plan, plan, {});
  align_storeys(building.committer, building.planes, {0, 0});
  ASSERT_EQ(building.aligned(), plan.size());
  // One wall turns out to stand elsewhere.
  const PlaneId wall{104};
  Plane moved = *building.graph.find(wall);
  moved.d += 0.15;
  building.graph.set(wall, moved);
  building.planes.refresh(building.graph, {});
  EXPECT_EQ(align_storeys(building.committer, building.planes, {0, 0}), 1);
  EXPECT_EQ(building.aligned(), plan.size() - 1);
}

}  // namespace
}  // namespace sgraph
