#include "sgraph_slam/core/mapping/submap.hpp"

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

Keyframe keyframe_at(const Pose& T_room_base) {
  Keyframe keyframe;
  keyframe.cloud = room_seen_from(T_room_base);
  return keyframe;
}

Matrix6 covariance(double angle, double distance) {
  Vector6 variance;
  variance << Eigen::Vector3d::Constant(angle * angle), Eigen::Vector3d::Constant(distance * distance);
  return variance.asDiagonal();
}

const Pose motion = se3_exp((Vector6() << 0.015, -0.01, 0.2, 0.6, 0.1, 0.01).finished());
const Pose wrong = motion * se3_exp((Vector6() << 0.015, -0.01, 0.02, 0.04, -0.03, 0.01).finished());

double error(const KeyframeMotion& found) { return se3_log(motion.inverse() * found.T_last_now).norm(); }

TEST(Submap, MeasuresAMotionThatTheOdometryKnowsPoorly) {
  Submap submap({}, {});
  submap.add(keyframe_at({}), {{}, covariance(0.015, 0.02)});
  const KeyframeMotion found = submap.add(keyframe_at(motion), {wrong, covariance(0.015, 0.02)});
  EXPECT_LT(error(found), 0.005);
  EXPECT_LT(found.covariance.trace(), covariance(0.015, 0.02).trace());
}

TEST(Submap, LeavesAGoodOdometryAlone) {
  Submap submap({}, {});
  submap.add(keyframe_at({}), {{}, covariance(0.001, 0.02)});
  const KeyframeMotion found = submap.add(keyframe_at(motion), {wrong, covariance(0.001, 0.02)});
  EXPECT_EQ(se3_log(wrong.inverse() * found.T_last_now).norm(), 0);
  EXPECT_EQ(found.covariance, covariance(0.001, 0.02));
}

TEST(Submap, BelievesTheOdometryWhereNothingMatches) {
  Submap submap({}, {});
  submap.add(keyframe_at({}), {{}, covariance(0.015, 0.02)});
  Keyframe elsewhere = keyframe_at({});
  auto far = std::make_shared<Cloud>(*elsewhere.cloud);
  for (Point& point : far->points) point.x += 40;
  elsewhere.cloud = far;
  const KeyframeMotion found = submap.add(elsewhere, {motion, covariance(0.015, 0.02)});
  EXPECT_LT(error(found), 1e-12);
  EXPECT_EQ(found.covariance, covariance(0.015, 0.02));
}

// A long bare corridor says nothing of the way along it: there the odometry's own uncertainty stays.
TEST(Submap, SaysWhatTheSubmapDoesNotHold) {
  const auto corridor = [](const Pose& T) {
    Keyframe keyframe = keyframe_at(T);
    auto open = std::make_shared<Cloud>();
    for (const Point& point : keyframe.cloud->points) {
      if (std::abs((T * point.position().cast<double>()).x()) < 2.9) open->points.push_back(point);
    }
    keyframe.cloud = open;
    return keyframe;
  };
  Submap submap({}, {});
  submap.add(corridor({}), {{}, covariance(0.015, 0.2)});
  const Pose along = se3_exp((Vector6() << 0, 0, 0, 0.3, 0, 0).finished());
  const KeyframeMotion found = submap.add(corridor(along), {along, covariance(0.015, 0.2)});
  EXPECT_GT(std::sqrt(found.covariance(3, 3)), 0.15);
  EXPECT_LT(std::sqrt(found.covariance(4, 4)), 0.05);
}

}  // namespace
}  // namespace sgraph
