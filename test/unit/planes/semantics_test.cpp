#include "sgraph_slam/core/planes/dominant_frame.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace sgraph {
namespace {

constexpr double degree = M_PI / 180;
const DominantFrameParams params;

TEST(DominantFrame, AnglesWrapToAQuarterTurn) {
  for (int degrees = -720; degrees <= 720; ++degrees) {
    const double wrapped = wrap_quarter(degrees * degree);
    EXPECT_GE(wrapped, -45 * degree - 1e-9);
    EXPECT_LT(wrapped, 45 * degree + 1e-9);
    EXPECT_NEAR(std::remainder(wrapped - degrees * degree, M_PI / 2), 0, 1e-9);
  }
}

TEST(DominantFrame, IsTheHeadingThatMostWallHas) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.5 * degree);
  for (int degrees = -45; degrees < 45; degrees += 3) {
    std::vector<WallDirection> walls;
    for (int i = 0; i < 40; ++i) walls.push_back({degrees * degree + (i % 4) * M_PI / 2 + noise(random), 3.0});
    for (int i = 0; i < 10; ++i) walls.push_back({(degrees + 30) * degree + noise(random), 3.0});  // another wing
    const DominantFrame frame = estimate_dominant_frame(walls, {}, params);
    EXPECT_NEAR(wrap_quarter(frame.yaw - degrees * degree), 0, 0.3 * degree) << degrees;
  }
}

TEST(DominantFrame, WaitsForEnoughWall) {
  EXPECT_FALSE(estimate_dominant_frame({}, {}, params).known());
  EXPECT_FALSE(estimate_dominant_frame({{0.3, 1.0}}, {}, params).known());
  EXPECT_TRUE(estimate_dominant_frame({{0.3, 10.0}}, {}, params).known());
}

TEST(DominantFrame, StaysUntilAnotherIsClearlyBetter) {
  const DominantFrame present{0.1, 20};
  const WallDirection here{0.1, 20};
  EXPECT_NEAR(estimate_dominant_frame({here, {0.5, 22}}, present, params).yaw, 0.1, 1e-6);
  EXPECT_NEAR(estimate_dominant_frame({here, {0.5, 60}}, present, params).yaw, 0.5, 1e-6);
}

// At the end of its range the frame must not jump by 90 degrees: x and y planes would change names.
TEST(DominantFrame, HasNoStepAtFortyFiveDegrees) {
  DominantFrame frame{44.5 * degree, 20};
  for (double degrees = 44.5; degrees < 47; degrees += 0.25) {
    frame = estimate_dominant_frame({{degrees * degree, 20}}, frame, params);
    EXPECT_NEAR(frame.yaw, degrees * degree, 1e-6);
  }
}

TEST(PlaneClasses, FollowTiltAndHeading) {
  const PlaneClassParams classes;
  const DominantFrame frame{20 * degree, 50};
  const auto at = [](double yaw_degrees, double elevation_degrees) -> Eigen::Vector3d {
    const double yaw = yaw_degrees * degree;
    const double e = elevation_degrees * degree;
    return {std::cos(yaw) * std::cos(e), std::sin(yaw) * std::cos(e), std::sin(e)};
  };
  const auto none = PlaneClass::unclassified;
  EXPECT_EQ(classify(at(20, 0), frame, none, classes), PlaneClass::x);
  EXPECT_EQ(classify(at(200, 0), frame, none, classes), PlaneClass::x);
  EXPECT_EQ(classify(at(110, 5), frame, none, classes), PlaneClass::y);
  EXPECT_EQ(classify(at(-70, -5), frame, none, classes), PlaneClass::y);
  EXPECT_EQ(classify(at(65, 0), frame, none, classes), none);
  EXPECT_EQ(classify(at(0, 90), frame, none, classes), PlaneClass::horizontal);
  EXPECT_EQ(classify(at(0, -80), frame, none, classes), PlaneClass::horizontal);
  EXPECT_EQ(classify(at(20, 45), frame, none, classes), none);
}

TEST(PlaneClasses, AreLeftOnlyBeyondTheHysteresis) {
  const PlaneClassParams classes;
  const DominantFrame frame{0, 50};
  const auto at = [](double degrees) -> Eigen::Vector3d { return {std::cos(degrees * degree), std::sin(degrees * degree), 0}; };
  EXPECT_EQ(classify(at(16), frame, PlaneClass::unclassified, classes), PlaneClass::unclassified);
  EXPECT_EQ(classify(at(16), frame, PlaneClass::x, classes), PlaneClass::x);
  EXPECT_EQ(classify(at(18), frame, PlaneClass::x, classes), PlaneClass::unclassified);
}

}  // namespace
}  // namespace sgraph
