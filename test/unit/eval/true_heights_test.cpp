#include "sgraph_slam/core/eval/true_heights.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sgraph_slam/core/types/storey.hpp"

namespace sgraph {
namespace {

StampedPose pose_at(int second, double x, double z) { return {Stamp::from_seconds(second), {Eigen::Quaterniond::Identity(), {x, 0, z}}}; }

// Ten seconds on one storey, a ride, ten on another, 3 m above, of which the map has it that it is 0.2 m above.
struct Ride {
  Trajectory estimate;
  Trajectory truth;
  GraphSnapshot graph;
};

Ride ride(bool height_known) {
  Ride r;
  for (int i = 1; i <= 25; ++i) {
    const bool up = i > 15;
    const double error = i % 2 == 0 ? 0.01 : -0.01;
    r.truth.push_back(pose_at(i, i, i <= 10 ? 0 : up ? 3 : 0.6 * (i - 10)));
    r.estimate.push_back(pose_at(i, i + error, (up ? 0.2 : 0) + error));
    if (i > 10 && i < 15) continue;  // none is taken in the lift, but one at its end
    SceneKeyframe keyframe;
    keyframe.id = {i};
    keyframe.stamp = r.truth.back().stamp;
    keyframe.storey = up ? 1 : 0;
    r.graph.keyframes[keyframe.id] = keyframe;
  }
  r.graph.storeys = {{0, 0, 2.5, true}, {1, 0.2, 2.5, height_known}};
  return r;
}

TEST(TrueHeights, AStoreyOfUnknownHeightIsMovedWhereItIsAndTheRideLeftOut) {
  const Ride r = ride(false);
  const Trajectory moved = at_true_heights(r.estimate, r.truth, r.graph);
  ASSERT_EQ(moved.size(), 20U);
  EXPECT_EQ(moved[9].stamp, Stamp::from_seconds(10));
  EXPECT_EQ(moved[10].stamp, Stamp::from_seconds(16));
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const StampedPose& truth = r.truth[i < 10 ? i : i + 5];
    EXPECT_EQ(moved[i].stamp, truth.stamp);
    EXPECT_NEAR(std::abs(moved[i].pose.translation.x() - truth.pose.translation.x()), 0.01, 1e-9);  // other errors stay
    EXPECT_NEAR(moved[i].pose.translation.z(), truth.pose.translation.z(), 0.012);
  }
}

// On the way into a cabin the path may seem to climb, and what is taken there is on no storey.
TEST(TrueHeights, WhatIsOnNoStoreyBesideARideIsPartOfIt) {
  Ride r = ride(false);
  SceneKeyframe keyframe;
  keyframe.id = {12};
  keyframe.stamp = Stamp::from_seconds(12);
  keyframe.storey = stairwell;
  r.graph.keyframes[keyframe.id] = keyframe;
  r.graph.keyframes.at({15}).storey = stairwell;
  const Trajectory moved = at_true_heights(r.estimate, r.truth, r.graph);
  ASSERT_EQ(moved.size(), 19U);
  EXPECT_EQ(moved[8].stamp, Stamp::from_seconds(9));
  EXPECT_EQ(moved[9].stamp, Stamp::from_seconds(16));
}

TEST(TrueHeights, KnownHeightsAreComparedAsTheyAre) {
  const Ride r = ride(true);
  const Trajectory same = at_true_heights(r.estimate, r.truth, r.graph);
  ASSERT_EQ(same.size(), r.estimate.size());
  EXPECT_EQ(same.back().pose.translation, r.estimate.back().pose.translation);
}

}  // namespace
}  // namespace sgraph
