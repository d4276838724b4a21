#include "sgraph_slam/core/odometry/ride_height.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace sgraph {
namespace {

constexpr double gravity = 9.81;

struct Unit {
  double noise = 0.04;                             // of one reading [m/s^2]
  Eigen::Vector3d bias{0.03, -0.02, 0.03};         // [m/s^2]
  Eigen::Quaterniond mount{0.9, 0.1, -0.3, 0.28};  // upside or tilted, as it pleases
  double scale = 1;                                // to the unit in which it reads
  double drift = 0;                                // change of the bias a second [m/s^3]
};

// Waits, rides (speeds up within `ramp` seconds, goes on, slows down), waits.
std::vector<ImuSample> ride(double height, const Unit& unit = {}, unsigned seed = 1, double rate = 100) {
  constexpr double wait = 6, ramp = 1.5, top_speed = 1.0;
  const double coast = std::max(0.0, std::abs(height) / top_speed - ramp);
  const double acceleration = height / (ramp * (ramp + coast));
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal(0, unit.noise);
  std::vector<ImuSample> samples;
  for (int i = 0; i < rate * (2 * wait + 2 * ramp + coast); ++i) {
    const double t = i / rate - wait;
    const double a = t > 0 && t < ramp ? acceleration : t > ramp + coast && t < 2 * ramp + coast ? -acceleration : 0;
    ImuSample sample;
    sample.stamp = Stamp::from_seconds(100 + i / rate);
    sample.linear_acceleration = unit.mount.normalized().conjugate() * Eigen::Vector3d(0, 0, gravity + a) + unit.bias +
                                 Eigen::Vector3d(normal(generator), normal(generator), normal(generator)) +
                                 Eigen::Vector3d(0, 0, unit.drift * i / rate);
    sample.linear_acceleration *= unit.scale;
    samples.push_back(sample);
  }
  return samples;
}

std::optional<Rise> measured(const std::vector<ImuSample>& samples) {
  RideHeight ride_height;
  for (const ImuSample& sample : samples) ride_height.add(sample);
  return ride_height.risen();
}

// 4 cm rms here; the bar is 0.3 m.
TEST(RideHeight, MeasuresRidesUpAndDown) {
  for (const double height : {3.2, -3.2, 6.4, 16.0, -0.9}) {
    double squares = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const auto rise = measured(ride(height, {}, seed));
      ASSERT_TRUE(rise);
      EXPECT_LT(std::abs(rise->height - height), 3 * rise->sigma) << height << ", seed " << seed;
      EXPECT_LT(rise->sigma, std::abs(height) > 10 ? 0.3 : 0.15);
      squares += std::pow((rise->height - height) / rise->sigma, 2) / 20;
    }
    EXPECT_LT(squares, 2) << "overconfident at " << height;
  }
}

TEST(RideHeight, AsksForNeitherUnitNorMountNorCalibration) {
  Unit in_g;
  in_g.scale = 1 / gravity;
  Unit upside_down;
  upside_down.mount = {0, 1, 0, 0};
  Unit badly_scaled;
  badly_scaled.scale = 1.03;
  for (const Unit& unit : {in_g, upside_down, badly_scaled}) EXPECT_NEAR(measured(ride(3.2, unit))->height, 3.2, 0.2);
}

TEST(RideHeight, AChangingBiasIsWithinItsSigma) {
  Unit warm;
  warm.drift = 0.0003;
  const auto rise = measured(ride(6.4, warm));
  EXPECT_LT(std::abs(rise->height - 6.4), 3 * rise->sigma);
}

TEST(RideHeight, StandingIsNoRide) {
  const auto rise = measured(ride(0));
  ASSERT_TRUE(rise);
  EXPECT_LT(std::abs(rise->height), 3 * rise->sigma);
  EXPECT_LT(rise->sigma, 0.3);
}

TEST(RideHeight, SaysNothingOfWhatItDidNotMeasure) {
  EXPECT_FALSE(measured({}));
  std::vector<ImuSample> holes = ride(3.2);
  holes.erase(holes.begin() + 700, holes.begin() + 750);
  EXPECT_FALSE(measured(holes));
  std::vector<ImuSample> frozen = ride(3.2);
  for (ImuSample& sample : frozen) sample.linear_acceleration = frozen.front().linear_acceleration;
  EXPECT_FALSE(measured(frozen));
  std::vector<ImuSample> without_gravity = ride(3.2);
  for (ImuSample& sample : without_gravity) sample.linear_acceleration *= 0.01;
  EXPECT_FALSE(measured(without_gravity));
  std::vector<ImuSample> not_finite = ride(3.2);
  for (std::size_t i = 0; i < not_finite.size(); i += 50) not_finite[i].linear_acceleration.x() = NAN;
  EXPECT_NEAR(measured(not_finite)->height, 3.2, 0.2);
  EXPECT_FALSE(measured(ride(400)));  // 400 s: its beginning has been forgotten
}

TEST(RideHeight, ForgetsWhatWasBefore) {
  RideHeight ride_height;
  for (const ImuSample& sample : ride(3.2)) ride_height.add(sample);
  ride_height.forget_before(Stamp::from_seconds(112));
  const auto rise = ride_height.risen();
  ASSERT_TRUE(rise);
  EXPECT_LT(std::abs(rise->height), 3 * rise->sigma);
}

}  // namespace
}  // namespace sgraph
