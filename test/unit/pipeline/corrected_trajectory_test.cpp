#include <gtest/gtest.h>

#include <random>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/pipeline/pipeline.hpp"

namespace sgraph {
namespace {

double distance(const Pose& a, const Pose& b) { return se3_log(a.inverse() * b).norm(); }

// A walk of `scans` scans at 10 Hz, `origin` away from the odometry's origin; a keyframe every 8 scans and at the end.
GraphSnapshot walk(int scans, const Eigen::Vector3d& origin) {
  GraphSnapshot snapshot;
  Pose T_odom_base{Eigen::Quaterniond::Identity(), origin};
  SceneKeyframe keyframe;
  Trajectory since;
  std::mt19937 random(23);
  std::normal_distribution<double> normal(0, 0.02);
  for (int i = 0; i < scans; ++i) {
    Vector6 step;
    step << normal(random), normal(random), 0.05, 0.1, normal(random), normal(random);
    T_odom_base = T_odom_base * se3_exp(step);
    const Stamp stamp{1'700'000'000'000'000'000 + i * 100'000'000LL};
    since.push_back({stamp, T_odom_base});
    if (i % 8 != 0 && i + 1 != scans) continue;
    keyframe.id = KeyframeId{static_cast<std::int64_t>(snapshot.keyframes.size())};
    keyframe.stamp = stamp;
    keyframe.T_odom_base = T_odom_base;
    keyframe.T_map_base = T_odom_base;
    keyframe.scans = since;
    snapshot.keyframes.emplace(keyframe.id, keyframe);
    since.clear();
  }
  return snapshot;
}

TEST(CorrectedTrajectory, WithoutCorrectionsIsTheOdometry) {
  const GraphSnapshot snapshot = walk(50, {3, -2, 1});
  const Trajectory trajectory = corrected_trajectory(snapshot);
  ASSERT_EQ(trajectory.size(), 50U);
  std::size_t i = 0;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    for (const StampedPose& scan : *keyframe.scans) {
      EXPECT_EQ(trajectory[i].stamp, scan.stamp);
      EXPECT_LT(distance(trajectory[i++].pose, scan.pose), 1e-12);
    }
  }
}

TEST(CorrectedTrajectory, FollowsAMapThatMovesAsAWhole) {
  GraphSnapshot snapshot = walk(50, {3, -2, 1});
  Vector6 xi;
  xi << 0.1, -0.2, 2.0, 5, 6, -7;
  const Pose T_map_odom = se3_exp(xi);
  for (auto& [id, keyframe] : snapshot.keyframes) keyframe.T_map_base = T_map_odom * keyframe.T_odom_base;
  const Trajectory trajectory = corrected_trajectory(snapshot);
  std::size_t i = 0;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    for (const StampedPose& scan : *keyframe.scans) EXPECT_LT(distance(trajectory[i++].pose, T_map_odom * scan.pose), 1e-9);
  }
}

// Keyframes that the graph moved each on its own: their scans are there, and those between them go over smoothly, also a kilometre from the origin.
TEST(CorrectedTrajectory, PassesThroughTheKeyframesWithoutSteps) {
  for (const double far : {0.0, 1000.0}) {
    GraphSnapshot snapshot = walk(81, {far, far, 0});
    std::mt19937 random(5);
    std::normal_distribution<double> normal(0, 0.03);
    for (auto& [id, keyframe] : snapshot.keyframes) {
      Vector6 xi;
      for (int k = 0; k < 6; ++k) xi[k] = normal(random);
      keyframe.T_map_base = keyframe.T_odom_base * se3_exp(xi);
    }
    const Trajectory trajectory = corrected_trajectory(snapshot);
    ASSERT_EQ(trajectory.size(), 81U);
    for (const auto& [id, keyframe] : snapshot.keyframes) EXPECT_LT(distance(pose_at(trajectory, keyframe.stamp), keyframe.T_map_base), 1e-7);
    // Steps of the odometry are 0.1 m; corrections of neighbouring keyframes differ by some 0.05 m, an eighth of it a scan.
    for (std::size_t i = 1; i < trajectory.size(); ++i) {
      EXPECT_LT((trajectory[i].pose.translation - trajectory[i - 1].pose.translation).norm(), 0.15) << i << " at " << far;
    }
  }
}

TEST(CorrectedTrajectory, OfAnEmptyMapIsEmpty) { EXPECT_TRUE(corrected_trajectory(GraphSnapshot()).empty()); }

}  // namespace
}  // namespace sgraph
