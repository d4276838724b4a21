#include "sgraph_slam/core/odometry/motion_sensors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

const Pose T_base_lidar{so3_exp({0.1, -0.4, 0.7}), {0.2, -0.1, 0.5}};

ImuSample rate_at(double time, const Eigen::Vector3d& rate) {
  ImuSample sample;
  sample.stamp = Stamp::from_seconds(time);
  sample.angular_velocity = rate;
  return sample;
}

TEST(MotionSensors, GyroAndOdometryGiveTheLidarsMotion) {
  // The base turns at a constant rate and goes along a straight line in the odometry's frame.
  const Eigen::Vector3d rate(0.1, -0.2, 0.9);
  const auto base_at = [&](double t) { return Pose{so3_exp(rate * t), {0.8 * t, 0.1 * t, 0}}; };
  MotionSensors sensors(T_base_lidar);
  for (int i = 0; i <= 200; ++i) {
    sensors.add(rate_at(0.01 * i, rate));
    sensors.add(OdometrySample{Stamp::from_seconds(0.01 * i), base_at(0.01 * i), Matrix6::Zero()});
  }
  for (const double begin : {0.3, 0.305, 1.934}) {
    const double end = begin + 0.057;
    const Pose expected = (base_at(begin) * T_base_lidar).inverse() * (base_at(end) * T_base_lidar);
    const auto measured = sensors.between(Stamp::from_seconds(begin), Stamp::from_seconds(end));
    ASSERT_EQ(measured.size(), 2U);
    EXPECT_LT(rotation_angle(measured[0].motion.rotation, expected.rotation), 1e-6);
    EXPECT_EQ((measured[0].information.bottomRightCorner<3, 3>().norm()), 0) << "a gyro measures no translation";
    EXPECT_LT(se3_log(measured[1].motion.inverse() * expected).norm(), 1e-4);
    EXPECT_GT(measured[1].information.diagonal().minCoeff(), 0);
  }
  EXPECT_TRUE(sensors.between(Stamp::from_seconds(1.9), Stamp::from_seconds(2.2)).empty()) << "beyond the last sample";
}

TEST(MotionSensors, LeavesOutHolesAndNonsense) {
  MotionSensors sensors({});
  EXPECT_TRUE(sensors.between(Stamp::from_seconds(0), Stamp::from_seconds(0.1)).empty());
  sensors.add(rate_at(0.0, {0, 0, 1}));
  sensors.add(rate_at(0.01, {0, 0, std::numeric_limits<double>::quiet_NaN()}));
  sensors.add(rate_at(1.0, {0, 0, 1}));
  sensors.add(rate_at(0.5, {0, 0, 9}));
  EXPECT_FALSE(sensors.rotation_by_gyro(Stamp::from_seconds(0.1), Stamp::from_seconds(0.2))) << "a second without a reading";
  for (int i = 1; i < 20; ++i) sensors.add(rate_at(1 + 0.01 * i, {0, 0, 1}));
  const auto turn = sensors.rotation_by_gyro(Stamp::from_seconds(1.0), Stamp::from_seconds(1.1));
  ASSERT_TRUE(turn);
  EXPECT_NEAR(yaw_of(*turn), 0.1, 1e-9);
}

TEST(MotionSensors, LearnsTheGyrosBias) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const Eigen::Vector3d bias(0.01, -0.02, 0.03);
  MotionSensors sensors(T_base_lidar);
  for (int i = 0; i <= 6000; ++i) {
    const double time = 0.01 * i;
    const Eigen::Vector3d rate(0, 0.3 * std::sin(time), 0.5);
    sensors.add(rate_at(time, rate + bias + 0.003 * Eigen::Vector3d(normal(random), normal(random), normal(random))));
    if (i < 20 || i % 10 != 0) continue;
    const Eigen::Vector3d mean_rate(0, 0.3 * (std::cos(time - 0.1) - std::cos(time)) / 0.1, 0.5);
    const Eigen::Quaterniond turn = so3_exp(T_base_lidar.rotation.conjugate() * (0.1 * mean_rate));
    sensors.learn(Stamp::from_seconds(time - 0.1), Stamp::from_seconds(time), turn);
  }
  EXPECT_LT((sensors.gyro_bias() - bias).norm(), 0.001);
}

TEST(MotionSensors, StopsListeningToAGyroThatIsWrong) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> nonsense(-2, 2);
  MotionSensors sensors({});
  for (int i = 0; i <= 1000; ++i) {
    sensors.add(rate_at(0.01 * i, {nonsense(random), nonsense(random), nonsense(random)}));
    if (i >= 20 && i % 10 == 0) sensors.learn(Stamp::from_seconds(0.01 * i - 0.1), Stamp::from_seconds(0.01 * i), Eigen::Quaterniond::Identity());
  }
  EXPECT_FALSE(sensors.rotation_by_gyro(Stamp::from_seconds(9.8), Stamp::from_seconds(9.9)));
}

// Wheels that are 2 % larger than believed, of which one drags; where the motion is not known nothing is learnt.
TEST(MotionSensors, LearnsTheErrorsOfTheRobotsOdometry) {
  for (const bool known : {true, false}) {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 0.002);
    MotionSensors sensors(T_base_lidar);
    Pose truth;
    Pose said;
    Pose before;  // at 118 s,
    Pose after;   // and at 119 s
    const double step = 0.02;
    for (int i = 0; i <= 6000; ++i) {
      const double speed = 0.8;
      const double rate = 0.6 * std::sin(0.005 * i);
      truth = truth * Pose{so3_exp({0, 0, rate * step}), {speed * step, 0, 0}};
      said = said * Pose{so3_exp({0, 0, (rate - 0.01 * speed) / 1.03 * step}), {speed / 1.02 * step, 0, 0}};
      const Stamp stamp = Stamp::from_seconds(step * i);
      sensors.add(OdometrySample{stamp, said, Matrix6::Zero()});
      if (i == 5900) before = truth;
      if (i == 5950) after = truth;
      if (i % 5 != 0) continue;
      Pose seen = truth * T_base_lidar;
      seen.translation += Eigen::Vector3d(noise(random), noise(random), noise(random));
      sensors.learn_motion(stamp, seen, known);
    }
    EXPECT_NEAR(sensors.odometry_errors().scale, known ? 0.02 : 0, 0.002);
    EXPECT_NEAR(sensors.odometry_errors().turn, known ? 0.03 : 0, 0.01);
    EXPECT_NEAR(sensors.odometry_errors().bend, known ? 0.01 : 0, 0.002);
    if (!known) continue;
    const auto motion = sensors.motion_by_odometry(Stamp::from_seconds(118), Stamp::from_seconds(119));
    ASSERT_TRUE(motion);
    const Pose base = T_base_lidar * *motion * T_base_lidar.inverse();
    EXPECT_LT((base.translation - (before.inverse() * after).translation).norm(), 0.005);
  }
}

}  // namespace
}  // namespace sgraph
