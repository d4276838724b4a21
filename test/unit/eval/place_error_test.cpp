#include "sgraph_slam/core/eval/place_error.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

const Pose T_truth_map{so3_exp({0, 0, 0.6}), {3, -2, 0.4}};

// A room as the map would hold it, given in the frame of the truth.
SceneRoom room(std::int64_t id, const Eigen::Vector2d& center, const Eigen::Vector2d& width, double yaw) {
  SceneRoom r;
  r.id = {id};
  r.center = T_truth_map.inverse() * Eigen::Vector3d(center.x(), center.y(), 1.3);
  r.width = width;
  r.yaw = yaw - 0.6;
  return r;
}

SceneCorridor corridor(std::int64_t id, const Eigen::Vector2d& center, double length, double width, double yaw) {
  const SceneRoom r = room(id, center, {length, width}, yaw);
  SceneCorridor c;
  c.id = {id};
  c.center = r.center;
  c.width = width;
  c.length = length;
  c.yaw = r.yaw;
  return c;
}

TEST(RoomScore, MeasuresCentreAndWidthsAfterTheAlignment) {
  const std::vector<PlanPlace> truth{{"A", {2, 3}, {6, 4}, 0.3, 0}};
  const Eigen::Vector2d shifted = Eigen::Vector2d(2, 3) + Eigen::Vector2d(0.03, 0.04);
  const PlaceScore score = score_rooms({room(7, shifted, {6.02, 3.95}, 0.3 + 0.01)}, T_truth_map, truth);
  ASSERT_EQ(score.matches.size(), 1u);
  EXPECT_EQ(score.matches[0].truth, "A");
  EXPECT_EQ(score.matches[0].estimate, 7);
  EXPECT_NEAR(score.matches[0].center_error, 0.05, 1e-9);
  EXPECT_NEAR(score.matches[0].width_error, 0.05, 1e-9);
  EXPECT_NEAR(score.matches[0].yaw_error, 0.01, 1e-9);
  EXPECT_EQ(score.precision(), 1);
  EXPECT_EQ(score.recall(), 1);
  EXPECT_NEAR(score.center_error().mean, 0.05, 1e-9);
}

TEST(RoomScore, AxesMayBeSwappedOrTurnedRound) {
  const std::vector<PlanPlace> truth{{"A", {0, 0}, {6, 4}, 0.2, 0}};
  for (const auto& [width, yaw] :
       {std::pair{Eigen::Vector2d(4, 6), 0.2 + M_PI_2}, {Eigen::Vector2d(4, 6), 0.2 - M_PI_2}, {Eigen::Vector2d(6, 4), 0.2 + M_PI}}) {
    const PlaceScore score = score_rooms({room(0, {0, 0}, width, yaw)}, T_truth_map, truth);
    ASSERT_EQ(score.matches.size(), 1u) << yaw;
    EXPECT_NEAR(score.matches[0].width_error, 0, 1e-9);
    EXPECT_NEAR(score.matches[0].yaw_error, 0, 1e-9);
    EXPECT_NEAR(score.matches[0].overlap, 1, 1e-9);
  }
}

TEST(RoomScore, CountsMissedInventedAndDoubled) {
  const std::vector<PlanPlace> truth{{"A", {0, 0}, {4, 4}, 0, 0}, {"B", {5, 0}, {4, 4}, 0, 0}, {"C", {10, 0}, {4, 4}, 0, 0}};
  const std::vector<SceneRoom> found{room(0, {0.5, 0}, {4, 4}, 0), room(1, {0.1, 0}, {4, 4}, 0), room(2, {5, 0}, {4, 4}, 0),
                                     room(3, {30, 0}, {4, 4}, 0)};
  const PlaceScore score = score_rooms(found, T_truth_map, truth);
  ASSERT_EQ(score.matches.size(), 2u);
  EXPECT_EQ(score.matches[0].estimate, 2);  // best first
  EXPECT_EQ(score.matches[1].estimate, 1);  // the better of the two on A
  EXPECT_EQ(score.missed, std::vector<std::string>{"C"});
  EXPECT_EQ(score.false_alarms, (std::vector<std::int64_t>{0, 3}));
  EXPECT_EQ(score.duplicates, 1);
  EXPECT_DOUBLE_EQ(score.precision(), 0.5);
  EXPECT_DOUBLE_EQ(score.recall(), 2.0 / 3);
}

TEST(RoomScore, PlacesThatTheRobotDoesNotEnterCountNowhere) {
  const std::vector<PlanPlace> truth{{"A", {0, 0}, {4, 4}, 0, 0}, {"seen", {5, 0}, {4, 4}, 0, 0, false}, {"unseen", {10, 0}, {4, 4}, 0, 0, false}};
  const PlaceScore score = score_rooms({room(0, {0, 0}, {4, 4}, 0), room(1, {5, 0}, {4, 4}, 0)}, T_truth_map, truth);
  EXPECT_EQ(score.truths, 1);
  EXPECT_EQ(score.estimates, 1);
  EXPECT_EQ(score.matches.size(), 1u);
  EXPECT_TRUE(score.missed.empty());
  EXPECT_TRUE(score.false_alarms.empty());
  EXPECT_DOUBLE_EQ(score_rooms({room(0, {5, 0}, {4, 4}, 0)}, T_truth_map, truth).recall(), 0);
}

TEST(RoomScore, HalfOfTheCommonAreaIsTheLimit) {
  const std::vector<PlanPlace> truth{{"A", {0, 0}, {6, 1}, 0, 0}};
  // Shifted by s: intersection 6 - s over union 6 + s is one half at s = 2.
  EXPECT_EQ(score_rooms({room(0, {1.99, 0}, {6, 1}, 0)}, T_truth_map, truth).matches.size(), 1u);
  EXPECT_EQ(score_rooms({room(0, {2.01, 0}, {6, 1}, 0)}, T_truth_map, truth).matches.size(), 0u);
}

TEST(RoomScore, EmptySides) {
  EXPECT_EQ(score_rooms({}, Pose{}, {}).precision(), 1);
  EXPECT_EQ(score_rooms({}, Pose{}, {}).recall(), 1);
  EXPECT_EQ(score_rooms({}, Pose{}, {{"A", {0, 0}, {6, 4}, 0, 0}}).recall(), 0);
  EXPECT_EQ(score_rooms({room(0, {0, 0}, {6, 4}, 0)}, T_truth_map, {}).precision(), 0);
  // A room without extent must not give a NaN.
  EXPECT_TRUE(score_rooms({room(0, {0, 0}, {0, 0}, 0)}, T_truth_map, {{"A", {0, 0}, {0, 0}, 0, 0}}).matches.empty());
}

TEST(CorridorScore, MeasuresAcrossOnly) {
  // The true one is given across first: its long side counts.
  const std::vector<PlanPlace> truth{{"c", {10, 1}, {2, 20}, M_PI_2, 0}};
  const PlaceScore score = score_corridors({corridor(4, {6, 1.03}, 8, 2.02, M_PI)}, T_truth_map, truth);
  ASSERT_EQ(score.matches.size(), 1u);
  EXPECT_NEAR(score.matches[0].center_error, 0.03, 1e-9);
  EXPECT_NEAR(score.matches[0].width_error, 0.02, 1e-9);
  EXPECT_NEAR(score.matches[0].overlap, 0.4, 1e-9);
}

TEST(CorridorScore, RefusesCrossingOutsideAndTooWide) {
  const std::vector<PlanPlace> truth{{"c", {0, 0}, {20, 2}, 0, 0}};
  EXPECT_TRUE(score_corridors({corridor(0, {0, 0}, 2, 2, M_PI_2)}, T_truth_map, truth).matches.empty());  // across it
  EXPECT_TRUE(score_corridors({corridor(0, {0, 1.5}, 8, 2, 0)}, T_truth_map, truth).matches.empty());     // beside it
  EXPECT_TRUE(score_corridors({corridor(0, {0, 0.4}, 8, 2.8, 0)}, T_truth_map, truth).matches.empty());   // another width
  const PlaceScore doubled = score_corridors({corridor(0, {-4, 0}, 4, 2, 0), corridor(1, {4, 0}, 6, 2, 0)}, T_truth_map, truth);
  ASSERT_EQ(doubled.matches.size(), 1u);
  EXPECT_EQ(doubled.matches[0].estimate, 1);
  EXPECT_EQ(doubled.duplicates, 1);
}

}  // namespace
}  // namespace sgraph
