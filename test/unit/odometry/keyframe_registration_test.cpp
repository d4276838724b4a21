#include "sgraph_slam/core/odometry/keyframe_registration.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph {
namespace {

// What a LiDAR sees of the walls, floor and ceiling of a room of 6 m x 4 m x 2.5 m.
CloudPtr room_seen_from(const Pose& T_room_lidar) {
  auto cloud = std::make_shared<Cloud>();
  const Pose T_lidar_room = T_room_lidar.inverse();
  const auto add = [&](double x, double y, double z) {
    const Eigen::Vector3f p = (T_lidar_room * Eigen::Vector3d(x, y, z)).cast<float>();
    Point& point = cloud->points.emplace_back();
    point.x = p.x();
    point.y = p.y();
    point.z = p.z();
  };
  constexpr double step = 0.07;
  for (double a = -3; a < 3; a += step) {
    for (double z = -1; z < 1.5; z += step) {
      add(a, -2, z);
      add(a, 2, z);
    }
    for (double y = -2; y < 2; y += step) {
      add(a, y, -1);
      add(a, y, 1.5);
    }
  }
  for (double y = -2; y < 2; y += step) {
    for (double z = -1; z < 1.5; z += step) {
      add(-3, y, z);
      add(3, y, z);
    }
  }
  return cloud;
}

Matrix6 covariance(double angle, double distance) {
  Vector6 variance;
  variance << Eigen::Vector3d::Constant(angle * angle), Eigen::Vector3d::Constant(distance * distance);
  return variance.asDiagonal();
}

// A keyframe taken at `T_room_base`, of which its odometry says `T_odom_base`.
Keyframe keyframe_at(const Pose& T_room_base, const Pose& T_odom_base, const Matrix6& uncertainty) {
  Keyframe keyframe;
  keyframe.cloud = room_seen_from(T_room_base);
  keyframe.T_odom_base = T_odom_base;
  keyframe.covariance = uncertainty;
  return keyframe;
}

const Matrix6 poor = covariance(0.015, 0.02);
const Pose motion = se3_exp((Vector6() << 0.015, -0.01, 0.2, 0.6, 0.1, 0.01).finished());
const Pose wrong = motion * se3_exp((Vector6() << 0.015, -0.01, 0.02, 0.04, -0.03, 0.01).finished());

TEST(KeyframeRegistration, MeasuresAMotionThatTheOdometryKnowsPoorly) {
  KeyframeRegistration registration({}, {});
  EXPECT_FALSE(registration.measure(keyframe_at({}, {}, poor)));
  const auto found = registration.measure(keyframe_at(motion, wrong, poor));
  ASSERT_TRUE(found);
  EXPECT_LT(se3_log(motion.inverse() * found->T_last_now).norm(), 0.005);
  EXPECT_LT(found->covariance.trace(), poor.trace());
}

TEST(KeyframeRegistration, LeavesAGoodOdometryAlone) {
  KeyframeRegistration registration({}, {});
  registration.measure(keyframe_at({}, {}, covariance(0.001, 0.02)));
  EXPECT_FALSE(registration.measure(keyframe_at(motion, wrong, covariance(0.001, 0.02))));
}

TEST(KeyframeRegistration, BelievesTheOdometryWhereNothingMatches) {
  KeyframeRegistration registration({}, {});
  registration.measure(keyframe_at({}, {}, poor));
  Keyframe elsewhere = keyframe_at({}, motion, poor);
  auto far = std::make_shared<Cloud>(*elsewhere.cloud);
  for (Point& point : far->points) point.x += 40;
  elsewhere.cloud = far;
  EXPECT_FALSE(registration.measure(elsewhere));
  const Keyframe back = keyframe_at({}, motion, poor);
  EXPECT_FALSE(registration.measure(back)) << "it has begun anew elsewhere";
  EXPECT_TRUE(registration.measure(back));
}

// A long bare corridor says nothing of the way along it: there the odometry's own uncertainty stays.
TEST(KeyframeRegistration, SaysWhatTheScanDoesNotHold) {
  const auto corridor = [](const Pose& T) {
    Keyframe keyframe = keyframe_at(T, T, covariance(0.015, 0.2));
    auto open = std::make_shared<Cloud>();
    for (const Point& point : keyframe.cloud->points) {
      if (std::abs((T * point.position().cast<double>()).x()) < 2.9) open->points.push_back(point);
    }
    keyframe.cloud = open;
    return keyframe;
  };
  KeyframeRegistration registration({}, {});
  registration.measure(corridor({}));
  const auto found = registration.measure(corridor(se3_exp((Vector6() << 0, 0, 0, 0.3, 0, 0).finished())));
  ASSERT_TRUE(found);
  EXPECT_GT(std::sqrt(found->covariance(3, 3)), 0.15);
  EXPECT_LT(std::sqrt(found->covariance(4, 4)), 0.05);
}

}  // namespace
}  // namespace sgraph
