#include "sgraph_slam/core/sim/motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/sim/proprioception.hpp"

namespace sgraph::sim {
namespace {

Route loop() {
  Route route;
  for (const auto& p : {Eigen::Vector2d(0, 0), {5, 0}, {5, 4}, {1, 4}, {4, 1}, {0, 0}}) route.waypoints.push_back({p, 0, 0});
  route.waypoints[2].wait = 2.0;
  route.start_heading = 0.6;
  return route;
}

MotionProfile walker() {
  MotionProfile profile;
  profile.speed = 1.6;
  profile.acceleration = 1.5;
  profile.turn_rate = 2.7;
  profile.turn_acceleration = 9.0;
  profile.tilt = 5 * M_PI / 180;
  return profile;
}

// Motion over ground alone: without sway.
MotionProfile still(MotionProfile profile) {
  profile.sway_roll = profile.sway_pitch = profile.sway_height = profile.tilt = 0;
  return profile;
}

TEST(Motion, KeepsToTheProfilesLimitsAndReachesThem) {
  for (const MotionProfile& profile : {still(MotionProfile{}), still(walker())}) {
    const Motion motion(loop(), profile, 0);
    double speed = 0;
    double turn = 0;
    double turn_acceleration = 0;
    double acceleration = 0;
    for (double t = 0; t < motion.duration(); t += 0.01) {
      const Vector6 twist = motion.twist_at(t);
      const Vector6 next = motion.twist_at(t + 0.01);
      speed = std::max(speed, twist.tail<3>().norm());
      turn = std::max(turn, std::abs(twist[2]));
      turn_acceleration = std::max(turn_acceleration, std::abs(next[2] - twist[2]) / 0.01);
      acceleration = std::max(acceleration, std::abs(next.tail<3>().norm() - twist.tail<3>().norm()) / 0.01);
    }
    EXPECT_LT(speed, 1.01 * profile.speed);
    EXPECT_GT(speed, 0.9 * profile.speed);
    EXPECT_LT(turn, 1.02 * profile.turn_rate);
    EXPECT_GT(turn, 0.9 * profile.turn_rate);
    EXPECT_LT(turn_acceleration, 1.5 * profile.turn_acceleration);
    EXPECT_GT(turn_acceleration, 0.7 * profile.turn_acceleration);
    EXPECT_LT(acceleration, 1.3 * profile.acceleration);
  }
}

TEST(Motion, StandsThenVisitsTheStopsThenStands) {
  Route route = loop();
  route.stand = 3;
  route.stand_end = 1;
  const Motion motion(route, MotionProfile{}, 1.5);
  const Pose start = motion.pose_at(0);
  EXPECT_NEAR(yaw_of(start.rotation), 0.6, 1e-9);
  EXPECT_LT((start.translation - Eigen::Vector3d(0, 0, 1.95)).norm(), 1e-9);
  EXPECT_LT((motion.pose_at(2.5).translation - start.translation).norm(), 1e-6);
  EXPECT_GT(motion.twist_at(4.0).norm(), 0.05);
  EXPECT_LT((motion.pose_at(motion.duration()).translation - start.translation).norm(), 1e-3);
  EXPECT_LT(motion.twist_at(motion.duration() - 0.2).norm(), 1e-6);
  double nearest_stop = 1e9;
  double nearest_corner = 1e9;
  for (double t = 0; t < motion.duration(); t += 0.02) {
    const Eigen::Vector2d p = motion.pose_at(t).translation.head<2>();
    nearest_stop = std::min(nearest_stop, (p - Eigen::Vector2d(5, 4)).norm());
    nearest_corner = std::min(nearest_corner, (p - Eigen::Vector2d(5, 0)).norm());
  }
  EXPECT_LT(nearest_stop, 1e-3);
  EXPECT_GT(nearest_corner, 0.05);  // rounded
  EXPECT_LT(nearest_corner, 0.5);
}

TEST(Motion, SwaysWhileItWalksOnly) {
  const Motion motion(loop(), MotionProfile{}, 0);
  double roll = 0;
  double pitch = 0;
  double height = 0;
  for (double t = 5; t < motion.duration() - 3; t += 0.005) {
    const Pose pose = motion.pose_at(t);
    const Eigen::Matrix3d R = Eigen::AngleAxisd(-yaw_of(pose.rotation), Eigen::Vector3d::UnitZ()) * pose.matrix();
    roll = std::max(roll, std::abs(std::atan2(R(2, 1), R(2, 2))));
    pitch = std::max(pitch, std::abs(std::asin(-R(2, 0))));
    height = std::max(height, std::abs(pose.translation.z() - 0.45));
  }
  EXPECT_NEAR(roll * 180 / M_PI, 1.0, 0.02);
  EXPECT_NEAR(pitch * 180 / M_PI, 0.8, 0.02);
  EXPECT_NEAR(height, 0.01, 2e-4);
  EXPECT_LT(rotation_angle(motion.pose_at(1).rotation, motion.pose_at(2).rotation), 1e-9);
}

TEST(Motion, AWishedDurationIsKept) {
  Route route = loop();
  route.duration = 100;
  EXPECT_NEAR(Motion(route, MotionProfile{}, 0).duration(), 100, 0.01);
  route.duration = 1;
  EXPECT_THROW(Motion(route, MotionProfile{}, 0), WorldError);
}

TEST(Motion, ARecordedWalkPassesThroughItsPosesWithoutSteps) {
  const Motion original(loop(), walker(), 0);
  Trajectory recorded;
  for (int i = 0; i * 0.05 < original.duration(); ++i) recorded.push_back({Stamp{5'000'000'000 + i * 50'000'000LL}, original.pose_at(i * 0.05)});
  const Motion copy(recorded);
  EXPECT_NEAR(copy.length(), original.length(), 0.1);
  double worst = 0;
  for (double t = 0; t < copy.duration() - 0.2; t += 0.0125) {
    worst = std::max(worst, (copy.pose_at(t).translation - original.pose_at(t).translation).norm());
    EXPECT_LT((copy.twist_at(t) - copy.twist_at(t + 1e-3)).norm(), 0.2);
  }
  EXPECT_LT(worst, 2e-3);
  recorded[3].stamp = recorded[2].stamp;
  EXPECT_THROW(Motion{recorded}, WorldError);
  EXPECT_THROW(Motion(Trajectory(recorded.begin(), recorded.begin() + 2)), WorldError);
}

TEST(Encoders, WithoutErrorsGiveTheTrueMotion) {
  const Motion motion(loop(), still(MotionProfile{}), 0);
  EncoderSettings settings;
  settings.scale = settings.heading_scale = settings.heading_drift = settings.distance_noise = settings.heading_noise = settings.slips_per_minute = 0;
  const auto readings = simulate_encoders(motion, motion.duration(), settings, 1, 1'000'000'000);
  const Pose start = motion.pose_at(0);
  for (std::size_t i = 0; i < readings.size(); i += 25) {
    const double t = static_cast<double>(i) * 0.02;
    EXPECT_EQ(readings[i].sample.stamp.nanoseconds, 1'000'000'000 + static_cast<std::int64_t>(i) * 20'000'000);
    const Pose expected = start.inverse() * motion.pose_at(t);
    EXPECT_LT((readings[i].sample.T_odom_base.translation.head<2>() - expected.translation.head<2>()).norm(), 2e-3);
    EXPECT_LT(rotation_angle(readings[i].sample.T_odom_base.rotation, expected.rotation), 1e-6);
  }
}

TEST(Encoders, DriftAsRealOnesDoAndTheSameForASeed) {
  const Motion motion(loop(), MotionProfile{}, 0);
  double mean = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto readings = simulate_encoders(motion, motion.duration(), {}, seed, 0);
    const auto again = simulate_encoders(motion, motion.duration(), {}, seed, 0);
    EXPECT_EQ(readings.back().sample.T_odom_base.translation, again.back().sample.T_odom_base.translation);
    mean += readings.back().sample.T_odom_base.translation.head<2>().norm() / 20;  // a loop: the truth is zero
  }
  EXPECT_GT(mean, 0.005 * motion.length());
  EXPECT_LT(mean, 0.05 * motion.length());
}

TEST(Imu, MeasuresTurningAndGravity) {
  const Motion motion(loop(), MotionProfile{}, 0);
  ImuSettings settings;
  settings.gyro_noise = settings.gyro_bias = settings.accel_noise = settings.accel_bias = 0;
  const auto readings = simulate_imu(motion, motion.duration(), settings, 1, 0);
  // Dead reckoning with the readings gives the true motion.
  Eigen::Quaterniond rotation = motion.pose_at(0).rotation;
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d position = motion.pose_at(0).translation;
  for (std::size_t i = 0; i + 1 < readings.size(); ++i) {
    const double dt = readings[i + 1].stamp - readings[i].stamp;
    const Eigen::Quaterniond next = rotation * so3_exp(0.5 * dt * (readings[i].angular_velocity + readings[i + 1].angular_velocity));
    const Eigen::Vector3d a =
        0.5 * (rotation * readings[i].linear_acceleration + next * readings[i + 1].linear_acceleration) - Eigen::Vector3d(0, 0, 9.81);
    position += dt * velocity + 0.5 * dt * dt * a;
    velocity += dt * a;
    rotation = next;
  }
  const Pose end = motion.pose_at(motion.duration());
  EXPECT_LT(rotation_angle(rotation, end.rotation), 0.002);
  EXPECT_LT((position - end.translation).norm(), 0.3);
  EXPECT_LT((readings[10].linear_acceleration - Eigen::Vector3d(0, 0, 9.81)).norm(), 1e-6);

  const auto noisy = simulate_imu(motion, 2.5, {}, 1, 0);
  double square = 0;
  for (std::size_t i = 1; i < noisy.size(); ++i) square += (noisy[i].angular_velocity - noisy[i - 1].angular_velocity).squaredNorm();
  EXPECT_NEAR(std::sqrt(square / (6.0 * static_cast<double>(noisy.size() - 1))), ImuSettings{}.gyro_noise, 3e-4);
}

}  // namespace
}  // namespace sgraph::sim
