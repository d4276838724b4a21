#include "sgraph_slam/core/math/noise.hpp"

#include <array>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include "sgraph_slam/core/util/rng.hpp"

namespace sgraph {
namespace {

TEST(Noise, PointsOfAPatchCountLessTheMoreTheyAre) {
  EXPECT_EQ(patch_effect(1), 1);
  EXPECT_EQ(patch_effect(0.2), 1);
  EXPECT_DOUBLE_EQ(patch_effect(5), 1 + 4 * noise::shared_in_patch);
  // However many they are, the mean of a patch is never better known than what they share.
  EXPECT_NEAR(patch_effect(1e6) / 1e6, noise::shared_in_patch, 1e-5);
  EXPECT_DOUBLE_EQ(points_on_patch(noise::patch / 5), 25);
  EXPECT_EQ(points_on_patch(2 * noise::patch), 1);
  EXPECT_EQ(points_on_patch(0), 1);
}

TEST(Noise, SharedErrorsAreThoseOfRepeatedFits) {
  // A line fitted to points of four groups, each with an error of its own.
  RandomStream random(4, 0);
  std::array<double, 40> x{};
  for (double& value : x) value = 3 * random.next_normal();
  Eigen::Matrix2d h = Eigen::Matrix2d::Zero();
  std::array<Eigen::Vector2d, 4> sums{};
  sums.fill(Eigen::Vector2d::Zero());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Eigen::Vector2d jacobian(x[i], 1);
    h += jacobian * jacobian.transpose();
    sums[i % 4] += jacobian;
  }
  SharedErrors<2> shared;
  for (const Eigen::Vector2d& sum : sums) shared.add(sum, 0.5);
  const Eigen::Matrix2d inverse = h.inverse();
  const Eigen::Matrix2d covariance = shared.covariance(inverse);
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  constexpr int fits = 4000;
  for (int k = 0; k < fits; ++k) {
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& sum : sums) gradient += 0.5 * random.next_normal() * sum;
    const Eigen::Vector2d error = inverse * gradient;
    spread += error * error.transpose() / fits;
  }
  EXPECT_LT((spread - covariance).norm(), 0.1 * covariance.norm());
}

}  // namespace
}  // namespace sgraph
