#include "sgraph_slam/core/odometry/motion.hpp"

#include <gtest/gtest.h>

#include <random>

#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph {
namespace {

Pose random_pose(std::mt19937& random, double turn, double way) {
  std::normal_distribution<double> normal;
  Vector6 xi;
  for (int k = 0; k < 6; ++k) xi[k] = (k < 3 ? turn : way) * normal(random);
  return se3_exp(xi);
}

TEST(Motion, SegmentsAgreeWithInterpolation) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const Pose begin = random_pose(random, 1, 5);
    const Pose end = i == 0 ? begin : begin * random_pose(random, 0.2, 0.3);
    const SegmentMotion motion(begin, end);
    const Eigen::Vector3d p(3, -2, 1);
    for (const double fraction : {-0.1, 0.0, 0.3, 1.0}) {
      EXPECT_LT((motion.rotate(fraction, p) + motion.origin(fraction) - interpolate(begin, end, fraction) * p).norm(), 1e-9);
    }
  }
}

// Points that stand still in the world, seen while the sensor moves, must coincide after deskewing: whatever the stamp's convention.
TEST(Motion, DeskewingUndoesTheMotion) {
  std::mt19937 random(2);
  Knots knots{{0.0, random_pose(random, 1, 5)}};
  for (const double time : {0.05, 0.1}) knots.push_back({time, knots.back().pose * random_pose(random, 0.1, 0.1)});
  for (const double stamp : {0.0, 0.1, 0.07}) {
    Cloud cloud;
    std::vector<Eigen::Vector3d> truth;
    for (int i = 0; i <= 100; ++i) {
      const double time = 0.001 * i;
      const Eigen::Vector3d p_odom = Eigen::Vector3d(4, 0.05 * i, 1);
      const Eigen::Vector3d p = pose_at(knots, time).inverse() * p_odom;
      Point point;
      point.x = static_cast<float>(p.x());
      point.y = static_cast<float>(p.y());
      point.z = static_cast<float>(p.z());
      point.time = static_cast<float>(time - stamp);
      cloud.points.push_back(point);
      truth.push_back(pose_at(knots, stamp).inverse() * p_odom);
    }
    const CloudPtr deskewed = deskew(cloud, stamp, knots);
    for (std::size_t i = 0; i < truth.size(); ++i) {
      EXPECT_LT((deskewed->points[i].position().cast<double>() - truth[i]).norm(), 2e-5);
      EXPECT_EQ(deskewed->points[i].time, 0);
    }
  }
}

}  // namespace
}  // namespace sgraph
