#include <gtest/gtest.h>

#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/odometry/keyframe_selector.hpp"

namespace sgraph {
namespace {

FinalScan scan_at(double seconds, const Pose& T_odom_base, const std::vector<Eigen::Vector3f>& positions, float time) {
  FinalScan scan;
  scan.stamp = Stamp::from_seconds(seconds);
  scan.T_odom_base = T_odom_base;
  auto cloud = std::make_shared<Cloud>();
  cloud->stamp = scan.stamp;
  cloud->frame = "velodyne";
  for (const Eigen::Vector3f& p : positions) {
    Point point;
    point.x = p.x();
    point.y = p.y();
    point.z = p.z();
    point.time = time;
    cloud->points.push_back(point);
  }
  scan.cloud = cloud;
  return scan;
}

// The robot goes 1 m ahead, then turns left by 90 degrees; the LiDAR sits 0.1 m before and 0.25 m above its base.
TEST(KeyframeCloud, PutsScansTogetherInTheLastOnesFrameWithTimesAndViewpoints) {
  KeyframeParams params;
  params.distance = 0.75;
  const Pose T_base_lidar{Eigen::Quaterniond::Identity(), {0.1, 0, 0.25}};
  KeyframeSelector selector(params, T_base_lidar);
  ASSERT_TRUE(selector.add(scan_at(10.0, {}, {{1, 0, 0}}, 0)));
  ASSERT_FALSE(selector.add(scan_at(10.1, {Eigen::Quaterniond::Identity(), {0.5, 0, 0}}, {{2, 0, 0}, {5, 5, 0}}, -0.05F)));
  const auto keyframe = selector.add(scan_at(10.2, {so3_exp(M_PI / 2 * Eigen::Vector3d::UnitZ()), {1, 0, 0}}, {{3, 0, 0}}, -0.02F));
  ASSERT_TRUE(keyframe);
  const Cloud& cloud = *keyframe->cloud;
  EXPECT_EQ(cloud.stamp, keyframe->stamp);
  ASSERT_EQ(cloud.size(), 3U);
  EXPECT_LT((cloud.points[0].position() - Eigen::Vector3f(3, 0, 0)).norm(), 1e-5) << "the newest scan's points stay as they are";
  EXPECT_NEAR(cloud.points[0].time, -0.02, 1e-6);
  // (2, 0, 0) in the LiDAR at base (0.5, 0, 0) is (2.6, 0, 0.25) in odom; from the base at (1, 0, 0), turned left, (0, -1.6, 0.25); less the LiDAR's
  // place.
  EXPECT_LT((cloud.points[1].position() - Eigen::Vector3f(-0.1F, -1.6F, 0)).norm(), 1e-5);
  EXPECT_NEAR(cloud.points[1].time, -0.15, 1e-6);
  ASSERT_EQ(cloud.viewpoints.size(), 2U);
  EXPECT_NEAR(cloud.viewpoints[0].time, -0.1, 1e-9);
  // The LiDAR was at (0.6, 0, 0.25) in odom.
  EXPECT_LT((cloud.viewpoints[0].position - Eigen::Vector3d(-0.1, 0.4, 0)).norm(), 1e-9);
  EXPECT_NEAR(cloud.viewpoints[1].time, 0, 1e-9);
  EXPECT_LT(cloud.viewpoints[1].position.norm(), 1e-9);
}

TEST(KeyframeCloud, KeepsTheNewerOfTwoPointsInAVoxel) {
  KeyframeParams params;
  params.distance = 0.1;
  KeyframeSelector selector(params, {});
  ASSERT_TRUE(selector.add(scan_at(10.0, {}, {{1, 0, 0}}, 0)));
  ASSERT_FALSE(selector.add(scan_at(10.1, {}, {{2.001F, 1, 1}, {4, 0, 0}}, -0.01F)));
  const auto keyframe = selector.add(scan_at(10.2, {Eigen::Quaterniond::Identity(), {0.2, 0, 0}}, {{1.801F, 1, 1}}, -0.03F));
  ASSERT_TRUE(keyframe);
  ASSERT_EQ(keyframe->cloud->size(), 2U);
  EXPECT_NEAR(keyframe->cloud->points[0].time, -0.03, 1e-6);
}

}  // namespace
}  // namespace sgraph
