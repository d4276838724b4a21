#include "sgraph_slam/core/eval/trajectory_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <stdexcept>

#include "sgraph_slam/core/io/tum.hpp"
#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

Pose at(double x, double y, double yaw_deg = 0) { return {so3_exp({0, 0, yaw_deg * M_PI / 180}), {x, y, 0}}; }

Pose random_pose(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Vector6 xi;
  for (int k = 0; k < 6; ++k) xi[k] = 2 * normal(random);
  return se3_exp(xi);
}

// A walk round a square of 20 m, 0.1 m and 0.1 s a step, with a little height so that no direction is flat.
Trajectory square_walk() {
  Trajectory walk;
  for (int i = 0; i < 800; ++i) {
    const double s = 0.1 * (i % 200);
    const int side = i / 200;
    const double x[] = {s, 20, 20 - s, 0};
    const double y[] = {0, s, 20, 20 - s};
    Pose pose = at(x[side], y[side], 90 * side);
    pose.translation.z() = 0.02 * std::sin(0.3 * i);
    walk.push_back({Stamp::from_seconds(0.1 * i), pose});
  }
  return walk;
}

void expect_like_evo(const Statistics& ours, const nlohmann::json& evo) {
  EXPECT_NEAR(ours.rmse, evo["rmse"], 1e-6);
  EXPECT_NEAR(ours.mean, evo["mean"], 1e-6);
  EXPECT_NEAR(ours.median, evo["median"], 1e-6);
  EXPECT_NEAR(ours.std, evo["std"], 1e-6);
  EXPECT_NEAR(ours.min, evo["min"], 1e-6);
  EXPECT_NEAR(ours.max, evo["max"], 1e-6);
  EXPECT_NEAR(ours.sse, evo["sse"], 1e-6);
}

// test/data/evaluation: a disturbed copy of a recording's truth, and what evo says of it.
TEST(TrajectoryError, AgreesWithEvo) {
  const Trajectory estimate = read_tum("test/data/evaluation/estimate.tum");
  const Trajectory truth = read_tum("test/data/evaluation/ground_truth.tum");
  const auto evo = nlohmann::json::parse(std::ifstream("test/data/evaluation/expected.json"));
  const auto pairs = pair_by_stamp(estimate, truth);
  EXPECT_EQ(static_cast<int>(pairs.size()), evo["pairs"].get<int>());

  const PoseErrorStatistics absolute = statistics_of(absolute_errors(pairs, align(pairs)));
  expect_like_evo(absolute.translation, evo["ape_translation_m"]);
  expect_like_evo(absolute.rotation_deg, evo["ape_rotation_deg"]);

  const PoseErrorStatistics relative = statistics_of(relative_errors(pairs, 10));
  EXPECT_EQ(relative.translation.count, evo["rpe_10m_translation_m"]["pairs"].get<int>());
  expect_like_evo(relative.translation, evo["rpe_10m_translation_m"]);
  expect_like_evo(relative.rotation_deg, evo["rpe_10m_rotation_deg"]);
}

TEST(TrajectoryError, PairsTheNearestWithinTheLimit) {
  const auto stamped = [](std::initializer_list<double> seconds) {
    Trajectory t;
    for (const double s : seconds) t.push_back({Stamp::from_seconds(s), at(s, 0)});
    return t;
  };
  const Trajectory truth = stamped({0.0, 0.1, 0.2, 0.3});
  const Trajectory estimate = stamped({0.109, 0.195, 0.35});
  const auto pairs = pair_by_stamp(estimate, truth, 0.01);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].stamp, estimate[0].stamp);
  EXPECT_DOUBLE_EQ(pairs[0].truth.translation.x(), 0.1);
  EXPECT_DOUBLE_EQ(pairs[1].truth.translation.x(), 0.2);
  // The longer list gives way to the shorter one, whichever is the estimate.
  const auto swapped = pair_by_stamp(truth, estimate, 0.01);
  ASSERT_EQ(swapped.size(), 2u);
  EXPECT_DOUBLE_EQ(swapped[0].estimate.translation.x(), 0.1);
  EXPECT_DOUBLE_EQ(swapped[0].truth.translation.x(), 0.109);
  EXPECT_TRUE(pair_by_stamp({}, truth).empty());
  EXPECT_TRUE(pair_by_stamp(estimate, stamped({7})).empty());
}

TEST(TrajectoryError, AlignmentUndoesAnyRigidMotion) {
  std::mt19937 random(5);
  const Trajectory truth = square_walk();
  for (int trial = 0; trial < 50; ++trial) {
    const Pose T_estimate_truth = random_pose(random);
    Trajectory estimate = truth;
    for (StampedPose& s : estimate) s.pose = T_estimate_truth * s.pose;
    const auto pairs = pair_by_stamp(estimate, truth);
    const Pose T = align(pairs);
    EXPECT_LT(se3_log(T * T_estimate_truth).norm(), 1e-9);
    for (const PoseError& e : absolute_errors(pairs, T)) EXPECT_LT(e.translation + e.rotation, 1e-9);
  }
}

TEST(TrajectoryError, AlignmentIsTheBestOneAndHasNoScale) {
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  const Trajectory truth = square_walk();
  Trajectory estimate = truth;
  for (StampedPose& s : estimate)
    s.pose.translation = 1.05 * s.pose.translation + 0.1 * Eigen::Vector3d(normal(random), normal(random), normal(random));
  const auto pairs = pair_by_stamp(estimate, truth);
  const Pose T = align(pairs);
  const double best = statistics_of(absolute_errors(pairs, T)).translation.sse;
  EXPECT_GT(best, 800 * 0.3);  // 5 % of 10 m is not taken out
  for (int trial = 0; trial < 200; ++trial) {
    Vector6 xi;
    for (int k = 0; k < 6; ++k) xi[k] = 1e-3 * normal(random);
    EXPECT_GT(statistics_of(absolute_errors(pairs, T * se3_exp(xi))).translation.sse, best);
  }
}

TEST(TrajectoryError, OrientationsSettleAStraightWalkAndAStandstill) {
  std::mt19937 random(8);
  for (const double step : {0.1, 0.0}) {
    Trajectory truth;
    for (int i = 0; i < 100; ++i) truth.push_back({Stamp::from_seconds(i), at(step * i, 0, 30)});
    const Pose T_estimate_truth = random_pose(random);
    Trajectory estimate = truth;
    for (StampedPose& s : estimate) s.pose = T_estimate_truth * s.pose;
    EXPECT_LT(se3_log(align(pair_by_stamp(estimate, truth)) * T_estimate_truth).norm(), 1e-6) << step;
  }
  EXPECT_THROW(align({}), std::runtime_error);
}

TEST(TrajectoryError, AbsoluteErrorsOfAKnownOffset) {
  const std::vector<PosePair> pairs{{{}, at(1, 0), at(1, 0)}, {{}, at(2, 0, 5), at(2, 0.3)}};
  const auto errors = absolute_errors(pairs, Pose{});
  EXPECT_DOUBLE_EQ(errors[0].translation, 0);
  EXPECT_DOUBLE_EQ(errors[1].translation, 0.3);
  EXPECT_NEAR(errors[1].rotation, 5 * M_PI / 180, 1e-12);
}

// An odometry 1 % too long that turns 0.1 deg a metre: both must come out.
TEST(TrajectoryError, DriftOfAKnownScaleAndTurn) {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i <= 500; ++i) {
    truth.push_back({Stamp::from_seconds(0.1 * i), at(0.1 * i, 0)});
    estimate.push_back({Stamp::from_seconds(0.1 * i), at(0.101 * i, 0)});
  }
  auto pairs = pair_by_stamp(estimate, truth);
  Drift d = drift(pairs, 10);
  EXPECT_EQ(d.segments, 41);  // begun at 0, 1, ... 40 m
  EXPECT_NEAR(d.translation_percent, 1, 1e-9);
  EXPECT_NEAR(d.rotation_deg_per_m, 0, 1e-9);

  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].estimate = at(0.1 * static_cast<double>(i), 0, 0.01 * static_cast<double>(i));
  d = drift(pairs, 10);
  EXPECT_NEAR(d.rotation_deg_per_m, 0.1, 1e-9);
  EXPECT_EQ(drift({}, 10).segments, 0);
  EXPECT_EQ(drift(pairs, 100).segments, 0);
}

TEST(TrajectoryError, RelativeErrorsBeginAfterTheFirstStretch) {
  std::vector<PosePair> pairs;
  for (int i = 0; i <= 35; ++i) pairs.push_back({Stamp::from_seconds(i), at(i, 0), at(i <= 15 ? i : i + 0.5, 0)});
  const auto errors = relative_errors(pairs, 10);  // 10..20 holds the jump, 20..30 not
  ASSERT_EQ(errors.size(), 2u);
  EXPECT_NEAR(errors[0].translation, 0.5, 1e-12);
  EXPECT_NEAR(errors[1].translation, 0, 1e-12);
}

TEST(TrajectoryError, StartToEndNeedsNoAlignment) {
  std::mt19937 random(9);
  const Pose frame = random_pose(random);
  // Truth comes back to where it began; the estimate ends 3 and 4 cm off, turned by 2 deg.
  const std::vector<PosePair> pairs{
      {{}, frame * at(0, 0), at(7, 7, 90)}, {{}, frame * at(5, 5), at(2, 12, 90)}, {{}, frame * at(0.03, 0.04, 2), at(7, 7, 90)}};
  const PoseError error = start_to_end_error(pairs);
  EXPECT_NEAR(error.translation, 0.05, 1e-12);
  EXPECT_NEAR(error.rotation, 2 * M_PI / 180, 1e-12);
  EXPECT_NEAR(path_length(pairs), 2 * std::hypot(5, 5), 1e-12);
  EXPECT_EQ(start_to_end_error({}).translation, 0);
}

TEST(Statistics, OfHandComputedSets) {
  const Statistics s = statistics_of(std::vector<double>{4, 1, 3, 2});
  EXPECT_EQ(s.count, 4);
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.sse, 30);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(1.25));
  EXPECT_EQ(s.min, 1);
  EXPECT_EQ(s.max, 4);
  EXPECT_EQ(statistics_of(std::vector<double>{}).rmse, 0);
  EXPECT_DOUBLE_EQ(quantile({5, 1, 3}, 0.25), 2);
  EXPECT_DOUBLE_EQ(quantile({5, 1, 3}, 1), 5);
  EXPECT_DOUBLE_EQ(quantile({}, 0.5), 0);
}

}  // namespace
}  // namespace sgraph
