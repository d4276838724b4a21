#include "sgraph_slam/core/odometry/keyframe_selector.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

FinalScan scan_at(int i, double x, double yaw) {
  auto cloud = std::make_shared<Cloud>();
  cloud->stamp = Stamp::from_seconds(0.1 * i);
  Point point;  // one point, fixed at (5, 0, 0) of odom
  const Pose T{so3_exp({0, 0, yaw}), Eigen::Vector3d(x, 0, 0)};
  const Eigen::Vector3f p = (T.inverse() * Eigen::Vector3d(5, 0, 0)).cast<float>();
  point.x = p.x();
  point.y = p.y();
  cloud->points.push_back(point);
  return {cloud->stamp, T, 1e-6 * Matrix6::Identity(), {}, cloud};
}

TEST(KeyframeSelector, EveryScanBelongsToExactlyOneKeyframe) {
  KeyframeParams params;
  KeyframeSelector selector(params, {});
  std::vector<Keyframe> keyframes;
  for (int i = 0; i < 100; ++i) {
    if (auto keyframe = selector.add(scan_at(i, 0.07 * i, 0))) keyframes.push_back(*keyframe);
  }
  if (auto keyframe = selector.finish()) keyframes.push_back(*keyframe);
  std::vector<Stamp> stamps;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    EXPECT_EQ(keyframes[k].id.value, static_cast<std::int64_t>(k));
    for (const StampedPose& s : keyframes[k].scans) stamps.push_back(s.stamp);
    EXPECT_EQ(keyframes[k].scans.back().stamp, keyframes[k].stamp);
    EXPECT_EQ(Eigen::LLT<Matrix6>(keyframes[k].covariance).info(), Eigen::Success);
  }
  ASSERT_EQ(stamps.size(), 100U);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(stamps[static_cast<std::size_t>(i)], Stamp::from_seconds(0.1 * i));
  // 0.07 m a scan: 11 scans are the first way of at least 0.75 m. The first scan is a keyframe of its own.
  EXPECT_EQ(keyframes[1].scans.size(), 11U);
}

TEST(KeyframeSelector, ARideInALiftPartsKeyframesAndLeavesTheHeightUnknown) {
  KeyframeSelector selector({}, {});
  std::vector<Keyframe> keyframes;
  for (int i = 0; i < 20; ++i) {
    FinalScan scan = scan_at(i, i < 10 ? 0.01 * i : 0.1 + 0.1 * (i - 10), 0);
    if (i == 10) scan.ride = unknown_rise;
    if (auto keyframe = selector.add(scan)) keyframes.push_back(*keyframe);
  }
  ASSERT_EQ(keyframes.size(), 3U);
  EXPECT_EQ(keyframes[1].scans.back().stamp, Stamp::from_seconds(0.9));
  EXPECT_LT(keyframes[1].covariance(5, 5), 0.01);
  EXPECT_FALSE(keyframes[1].ride);
  EXPECT_TRUE(keyframes[2].ride);
  EXPECT_NEAR(keyframes[2].covariance(5, 5), unknown_rise.sigma * unknown_rise.sigma, 0.1);
  EXPECT_LT(keyframes[2].covariance(3, 3), 0.01);
  EXPECT_LT(keyframes[2].covariance(4, 4), 0.01);
}

TEST(KeyframeSelector, ClosesByAngleAndByTime) {
  KeyframeParams params;
  params.angle = 0.5;
  KeyframeSelector by_angle(params, {});
  int closed = 0;
  for (int i = 0; i < 11; ++i) closed += by_angle.add(scan_at(i, 0, 0.101 * i)).has_value();
  EXPECT_EQ(closed, 3);  // at 0, 0.505 and 1.01 rad

  params.time = 0.5;
  KeyframeSelector by_time(params, {});
  closed = 0;
  for (int i = 0; i < 11; ++i) closed += by_time.add(scan_at(i, 0, 0)).has_value();
  EXPECT_EQ(closed, 3);
}

TEST(KeyframeSelector, PutsNoPointsOnTheMapFromPosesThatAreOnlyPredicted) {
  for (const char* cloud : {"scan", "scans"}) {
    KeyframeParams params;
    params.cloud = cloud;
    params.leaf = 0;
    KeyframeSelector selector(params, {});
    std::vector<Keyframe> keyframes;
    for (int i = 0; i < 30; ++i) {
      FinalScan scan = scan_at(i, 0.2 * i, 0);
      scan.accepted = i < 10 || i > 20;
      if (!scan.accepted) scan.T_odom_base.translation.y() = 3;  // carried away
      if (auto keyframe = selector.add(scan)) keyframes.push_back(*keyframe);
    }
    FinalScan lost = scan_at(30, 6, 0);
    lost.accepted = false;
    selector.add(lost);
    if (auto keyframe = selector.finish()) keyframes.push_back(*keyframe);
    std::size_t scans = 0;
    for (const Keyframe& keyframe : keyframes) {
      scans += keyframe.scans.size();
      EXPECT_NEAR(keyframe.T_odom_base.translation.y(), 0, 1e-9);
      for (const Point& p : keyframe.cloud->points)
        EXPECT_LT((keyframe.T_odom_base * p.position().cast<double>() - Eigen::Vector3d(5, 0, 0)).norm(), 1e-4);
    }
    EXPECT_EQ(scans, 31U) << "each scan keeps its place on the trajectory";
    EXPECT_LE(keyframes.back().cloud->size(), 1U);
  }
}

TEST(KeyframeSelector, PutsScansTogetherInTheLastOnesFrame) {
  KeyframeParams params;
  params.leaf = 0.02;
  KeyframeSelector selector(params, {});
  selector.add(scan_at(0, 0, 0));
  std::optional<Keyframe> keyframe;
  for (int i = 1; !keyframe; ++i) keyframe = selector.add(scan_at(i, 0.1 * i, 0.02 * i));
  // Every scan saw the same point: one remains, where the last scan sees it.
  const FinalScan last = scan_at(static_cast<int>(keyframe->scans.size()), 0.1 * static_cast<double>(keyframe->scans.size()),
                                 0.02 * static_cast<double>(keyframe->scans.size()));
  ASSERT_EQ(keyframe->cloud->size(), 1U);
  EXPECT_LT((keyframe->cloud->points[0].position() - last.cloud->points[0].position()).norm(), 1e-4F);
}

// Ten minutes of standing, or of scans that are not accepted, after a keyframe: what is held is bounded by what is seen.
TEST(KeyframeSelector, HoldsNoMoreTheLongerTheRobotStands) {
  for (const bool accepted : {true, false}) {
    KeyframeSelector selector({}, {});
    const auto standing = [&](int i) {
      FinalScan scan = scan_at(i, 0, 0);
      auto cloud = std::make_shared<Cloud>(*scan.cloud);
      for (int k = 0; k < 2000; ++k) {
        Point point;
        point.x = 4 + 0.001F * static_cast<float>((i * 7 + k) % 5);  // a wall, with noise
        point.y = 0.05F * static_cast<float>(k % 100);
        point.z = 0.05F * static_cast<float>(k / 100);
        cloud->points.push_back(point);
      }
      scan.cloud = cloud;
      scan.accepted = accepted || i == 0;
      scan.degenerate = {Vector6::Unit(3)};
      return scan;
    };
    ASSERT_TRUE(selector.add(standing(0)));
    std::size_t most = 0;
    for (int i = 1; i < 6000; ++i) {
      ASSERT_FALSE(selector.add(standing(i)));
      if (i % 100 == 0) most = std::max(most, selector.held_points());
    }
    EXPECT_LT(most, 70U * 2001U);
    const std::optional<Keyframe> keyframe = selector.add(scan_at(6000, 1, 0));
    ASSERT_TRUE(keyframe);
    EXPECT_EQ(keyframe->scans.size(), 6000U) << "each scan keeps its place on the trajectory";
    EXPECT_LT(keyframe->cloud->size(), 10000U);
    EXPECT_GT(keyframe->cloud->size(), accepted ? 1000U : 0U);
    EXPECT_LT(keyframe->cloud->viewpoints.size(), 70U);
    EXPECT_LT(keyframe->degenerate.size(), 70U);
    EXPECT_EQ(selector.held_points(), 0U);
  }
}

}  // namespace
}  // namespace sgraph
