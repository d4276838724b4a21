#include "sgraph_slam/core/loops/close_loop.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace sgraph {
namespace {

// Five keyframes on a round of 40 m that ends where it began, each with a few points for a cloud. Without the last motion the graph doesn't know
// where the newest one is.
struct Round {
  explicit Round(bool joined) {
    const std::vector<Eigen::Vector3d> way{{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}, {0.1, 0, 0}};
    for (std::size_t k = 0; k < way.size(); ++k) {
      const KeyframeId id{static_cast<std::int64_t>(k)};
      const Pose pose{Eigen::Quaterniond::Identity(), way[k]};
      Transaction edit;
      edit.keyframes[id] = pose;
      if (k > 0 && (joined || k + 1 < way.size()))
        add_factor(edit, Se3Between{{id.value - 1},
                                    id,
                                    {Eigen::Quaterniond::Identity(), way[k] - way[k - 1]},
                                    SqrtInformation<6>::from_std_dev(Vector6::Constant(1e-4))});
      EXPECT_TRUE(committer.commit(edit).ok());
      drift.add(id, pose, 1e-8 * Matrix6::Identity());
      auto cloud = std::make_shared<Cloud>();
      cloud->points.resize(3);
      keyframes[id] = {id, {}, pose, pose, Trajectory{}, CloudPtr(cloud)};
    }
  }

  bool close() { return close_loop(committer, loops, keyframes, drift, marginals); }

  Graph graph;
  DecisionLog log;
  Committer committer{graph, log};
  std::map<KeyframeId, SceneKeyframe> keyframes;
  OdometryDrift drift;
  MarginalsCache marginals;
  LoopCloser loops{{}, {}, {}};
};

TEST(CloseLoop, WhatTheGraphKnowsWellNeedsNoMatching) {
  Round round(true);
  EXPECT_FALSE(round.close());
  EXPECT_TRUE(round.log.empty());
}

// A sigma that the graph doesn't know is not a small one.
TEST(CloseLoop, WhatTheGraphDoesNotKnowIsTried) {
  Round round(false);
  EXPECT_FALSE(round.close());
  ASSERT_EQ(round.log.size(), 1U);
  EXPECT_FALSE(round.log[0].accepted);
  EXPECT_EQ(round.log[0].what, "loop keyframe/0 to keyframe/4");
}

}  // namespace
}  // namespace sgraph
