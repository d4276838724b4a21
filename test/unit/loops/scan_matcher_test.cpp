#include "sgraph_slam/core/loops/scan_matcher.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

const LoopParams params;

// Points on the walls and the floor of a room with a chimney, or of a bare corridor.
std::vector<Eigen::Vector3d> place(bool corridor, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> noise(0, 0.01);
  std::vector<Eigen::Vector3d> points;
  const double length = corridor ? 30 : 7;
  const double width = corridor ? 2.2 : 5;
  for (int i = 0; i < 3000; ++i) {
    const double x = (uniform(random) - 0.5) * length;
    const double y = (uniform(random) - 0.5) * width;
    const double z = 2.5 * uniform(random);
    points.emplace_back(x, -width / 2 + noise(random), z);
    points.emplace_back(x, width / 2 + noise(random), z);
    points.emplace_back(x, y, noise(random));
    if (corridor) continue;
    points.emplace_back(-length / 2 + noise(random), y, z);
    points.emplace_back(length / 2 + noise(random), y, z);
    if (i % 4 == 0) points.emplace_back(1.5 + noise(random), 0.8 + 0.6 * uniform(random), z);
    if (i % 4 == 1) points.emplace_back(1.5 + 0.6 * uniform(random), 0.8 + noise(random), z);
  }
  return points;
}

Cloud seen_from(const std::vector<Eigen::Vector3d>& points, const Pose& T_world_sensor) {
  Cloud cloud;
  for (const auto& p : points) {
    const Eigen::Vector3f q = (T_world_sensor.inverse() * p).cast<float>();
    if (q.norm() > 12) continue;
    Point& point = cloud.points.emplace_back();
    point.x = q.x();
    point.y = q.y();
    point.z = q.z();
  }
  return cloud;
}

TEST(ScanMatcher, FindsThePoseAgainFromARoughGuess) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 6; ++trial) {
    const Pose a = se3_exp((Vector6() << 0, 0, uniform(random), uniform(random), uniform(random), 0.6).finished());
    const Pose b = se3_exp((Vector6() << 0.01, 0.02, uniform(random), uniform(random), uniform(random), 0.6).finished());
    const Pose truth = a.inverse() * b;
    const Pose guess =
        truth * se3_exp((Vector6() << 0.01, -0.01, 0.08 * uniform(random), 0.3 * uniform(random), 0.3 * uniform(random), 0.05).finished());
    const ScanMatch match = match_scans(seen_from(place(false, 1), a), seen_from(place(false, 2), b), guess, params);
    EXPECT_EQ(match.failure, MatchFailure::none) << to_string(match.failure) << " " << match.fitness << " " << match.overlap;
    EXPECT_LT((match.T_target_source.translation - truth.translation).norm(), 0.03);
    EXPECT_LT(rotation_angle(match.T_target_source.rotation, truth.rotation), 0.01);
    EXPECT_LT(std::sqrt(match.covariance.diagonal().tail<3>().maxCoeff()), 0.1);
  }
}

// Nothing holds the motion along bare walls, and the covariance says so.
TEST(ScanMatcher, ABareCorridorLeavesItsDirectionOpen) {
  const Pose a = se3_exp((Vector6() << 0, 0, 0, 0, 0, 0.6).finished());
  const Pose b = se3_exp((Vector6() << 0, 0, 0, 1, 0.1, 0.6).finished());
  const ScanMatch match = match_scans(seen_from(place(true, 1), a), seen_from(place(true, 2), b), a.inverse() * b, params);
  EXPECT_GT(std::sqrt(match.covariance(3, 3)), 0.3);
  EXPECT_LT(std::sqrt(match.covariance(4, 4)), 0.1);
}

TEST(ScanMatcher, RefusesAnotherPlace) {
  const ScanMatch match = match_scans(seen_from(place(true, 1), {}), seen_from(place(false, 2), {}), {}, params);
  EXPECT_NE(match.failure, MatchFailure::none) << match.fitness << " " << match.overlap;
}

TEST(ScanMatcher, RefusesEmptyAndBrokenClouds) {
  Cloud broken = seen_from(place(false, 1), {});
  EXPECT_EQ(match_scans({}, broken, {}, params).failure, MatchFailure::empty);
  for (Point& p : broken.points) p.x = std::nanf("");
  EXPECT_EQ(match_scans(seen_from(place(false, 1), {}), broken, {}, params).failure, MatchFailure::empty);
}

}  // namespace
}  // namespace sgraph
