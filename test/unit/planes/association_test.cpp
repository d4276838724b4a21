#include "sgraph_slam/core/planes/association.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "sgraph_slam/core/graph/odometry_drift.hpp"
#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/planes/merging.hpp"
#include "support/mapped_building.hpp"

namespace sgraph {
namespace {

Vector6 random_vector(std::mt19937& random, double angle, double distance) {
  std::normal_distribution<double> normal;
  Vector6 xi;
  for (int i = 0; i < 6; ++i) xi[i] = normal(random) * (i < 3 ? angle : distance);
  return xi;
}

Plane moved(const Plane& plane, const Eigen::Vector3d& delta) {
  return {(plane.normal + tangent_basis(plane.normal) * delta.head<2>()).normalized(), plane.d + delta.z()};
}

TEST(Association, DerivativesAgreeWithDifferences) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 200; ++trial) {
    const Pose T_map_base = se3_exp(random_vector(random, 1, 5));
    const Pose T_base_lidar = se3_exp(random_vector(random, 1, 0.3));
    const Plane plane{Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized(), 4 * normal(random)};
    const Plane measured = moved((T_map_base * T_base_lidar).inverse() * plane, {0.02 * normal(random), 0.02 * normal(random), 0.1});
    const Innovation at = plane_innovation(plane, T_map_base, T_base_lidar, measured);
    const double h = 1e-6;
    for (int k = 0; k < 6; ++k) {
      const Vector6 step = h * Vector6::Unit(k);
      const Eigen::Vector3d numeric = (plane_innovation(plane, T_map_base * se3_exp(step), T_base_lidar, measured).residual -
                                       plane_innovation(plane, T_map_base * se3_exp(-step), T_base_lidar, measured).residual) /
                                      (2 * h);
      EXPECT_LT((numeric - at.d_keyframe.col(k)).norm(), 1e-6) << k;
    }
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(k);
      const Eigen::Vector3d numeric = (plane_innovation(moved(plane, step), T_map_base, T_base_lidar, measured).residual -
                                       plane_innovation(moved(plane, -step), T_map_base, T_base_lidar, measured).residual) /
                                      (2 * h);
      EXPECT_LT((numeric - at.d_plane.col(k)).norm(), 1e-5) << k;
    }
  }
}

TEST(Association, DifferenceOfNearlyEqualPlanesHasItsDerivative) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 100; ++trial) {
    const Plane a{Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized(), 4 * normal(random)};
    const Plane b = moved(a, {1e-4, -1e-4, 0.05});
    const Eigen::Vector3d point(normal(random), normal(random), normal(random));
    const PlaneDifference at = plane_difference(a, b, point);
    for (int k = 0; k < 6; ++k) {
      const Eigen::Vector3d step = 1e-5 * Eigen::Vector3d::Unit(k % 3);
      const Eigen::Vector3d numeric =
          k < 3 ? (plane_difference(moved(a, step), b, point).residual - plane_difference(moved(a, -step), b, point).residual) / 2e-5
                : (plane_difference(a, moved(b, step), point).residual - plane_difference(a, moved(b, -step), point).residual) / 2e-5;
      EXPECT_LT((numeric - at.derivative.col(k)).norm(), 2e-3) << k;
    }
  }
}

// A wall seen with the noise that the covariances promise: 95 % pass the gate.
TEST(Association, GateKeepsTheShareThatItPromises) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 0.02);
  AssociationParams params;
  params.sigma_angle = 0;
  params.sigma_distance = 0;
  const Plane wall{Eigen::Vector3d(-1, 0, 0), 4};
  const Outline outline{{4, -3, 0}, {4, 3, 0}, {4, 3, 2}, {4, -3, 2}};
  int kept = 0;
  const int trials = 1000;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 10; ++i) {
      for (int k = 0; k < 4; ++k) points.emplace_back(4 + normal(random), -2 + 0.4 * i, 0.5 * k);
    }
    const PlaneSegment segment = fit_segment(points, 0.02);
    const auto known = [](PlaneId, const Innovation&) -> Eigen::Matrix3d { return Eigen::Matrix3d::Zero(); };
    kept += static_cast<int>(associate(segment, {}, {}, {{{7}, wall, &outline}}, known, params).size());
  }
  EXPECT_NEAR(kept / static_cast<double>(trials), 0.95, 0.02);
}

// Two pieces of a wall, 5 m between their middles, and the same with a step of 5 cm between them.
TEST(Association, AStepIsToldFromNoiseWithinOneKeyframe) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 0.02);
  const auto piece = [&](double x, double from) {
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 40; ++i) {
      for (int k = 0; k < 6; ++k) points.emplace_back(x + normal(random), from + 0.1 * i, 0.4 * k);
    }
    const PlaneSegment segment = fit_segment(points, 0.02);
    return MeasuredPlane{segment.plane, segment.covariance};
  };
  int even = 0;
  int stepped = 0;
  const int trials = 400;
  for (int trial = 0; trial < trials; ++trial) {
    const MeasuredPlane here = piece(4, -5);
    even += static_cast<int>(are_apart(here, piece(4, 0), 7.81));
    stepped += static_cast<int>(are_apart(here, piece(4.05, 0), 7.81));
  }
  EXPECT_NEAR(even / static_cast<double>(trials), 0.05, 0.03);
  EXPECT_GT(stepped / static_cast<double>(trials), 0.95);
}

class TwoWalls : public testing::Test {
 protected:
  TwoWalls() {
    std::mt19937 random(4);
    std::normal_distribution<double> normal(0, 0.01);
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 20; ++i) {
      for (int k = 0; k < 4; ++k) points.emplace_back(4 + normal(random), -2 + 0.2 * i, 0.5 * k);
    }
    segment = fit_segment(points, 0.01);
  }
  std::vector<Match> match(const std::vector<PlaneCandidate>& candidates, double sigma = 0.01) const {
    const auto uncertain = [sigma](PlaneId, const Innovation&) -> Eigen::Matrix3d { return Eigen::Vector3d(1e-5, 1e-5, sigma * sigma).asDiagonal(); };
    return associate(segment, {}, {}, candidates, uncertain, AssociationParams());
  }
  PlaneSegment segment;
  Outline here{{4, -3, 0}, {4, 3, 0}, {4, 3, 2}, {4, -3, 2}};
  Outline beyond{{4, 8, 0}, {4, 12, 0}, {4, 12, 2}, {4, 8, 2}};
};

TEST_F(TwoWalls, TheOtherFaceIsNeverTaken) {
  const Plane other_face{Eigen::Vector3d(1, 0, 0), -4};  // the same place, facing away
  EXPECT_TRUE(match({{{0}, other_face, &here}}, 1.0).empty());
}

TEST_F(TwoWalls, TheLikelierOneWinsWhateverTheOrder) {
  const Plane near{Eigen::Vector3d(-1, 0, 0), 4.01};
  const Plane far{Eigen::Vector3d(-1, 0, 0), 4.08};
  const auto a = match({{{0}, far, &here}, {{1}, near, &here}}, 0.05);
  const auto b = match({{{1}, near, &here}, {{0}, far, &here}}, 0.05);
  ASSERT_EQ(a.size(), 2U);
  EXPECT_EQ(a.front().id.value, 1);
  EXPECT_EQ(b.front().id.value, 1);
}

TEST_F(TwoWalls, ACoplanarWallElsewhereIsAnother) {
  const Plane wall{Eigen::Vector3d(-1, 0, 0), 4};
  EXPECT_EQ(match({{{0}, wall, &here}}).size(), 1U);
  EXPECT_TRUE(match({{{0}, wall, &beyond}}).empty());
}

TEST_F(TwoWalls, UncertaintyOpensTheGate) {
  const Plane drifted{Eigen::Vector3d(-1, 0, 0), 4.3};
  EXPECT_TRUE(match({{{0}, drifted, &here}}, 0.02).empty());
  EXPECT_EQ(match({{{0}, drifted, &here}}, 0.2).size(), 1U);
}

// A keyframe that went through a door has seen both sides of its wall.
TEST_F(TwoWalls, SideIsUnsureWhenTheLidarWasOnBothSides) {
  EXPECT_FALSE(side_is_unsure(segment, {}));
  EXPECT_FALSE(side_is_unsure(segment, {{0, 0, 0}, {3, 1, 0}}));
  EXPECT_TRUE(side_is_unsure(segment, {{0, 0, 0}, {5, 1, 0}}));
}

TEST_F(TwoWalls, AFlippedSegmentIsTheOtherFacesWithTheSameUncertainty) {
  const PlaneSegment other = flipped(segment);
  const Plane face{Eigen::Vector3d(1, 0, 0), -4};
  const auto known = [](PlaneId, const Innovation&) -> Eigen::Matrix3d { return Eigen::Vector3d(1e-5, 1e-5, 1e-4).asDiagonal(); };
  EXPECT_EQ(associate(other, {}, {}, {{{0}, face, &here}}, known, AssociationParams()).size(), 1U);
  const PlaneSegment again = flipped(other);
  EXPECT_NEAR((again.covariance - segment.covariance).norm(), 0, 1e-12 * segment.covariance.norm());
  // The variance of the distance at the centroid is a property of the surface, whichever side it is seen from.
  const auto at_centroid = [](const PlaneSegment& s) {
    Eigen::Vector3d row;
    row << tangent_basis(s.plane.normal).transpose() * s.centroid, 1;
    return row.dot(s.covariance * row);
  };
  EXPECT_NEAR(at_centroid(other), at_centroid(segment), 1e-12);
}

// Sum of the steps' covariances against a thousand walks.
TEST(OdometryDrift, AgreesWithSampling) {
  std::mt19937 random(5);
  const std::vector<Pose> steps{se3_exp((Vector6() << 0, 0, 0.4, 1, 0, 0).finished()), se3_exp((Vector6() << 0, 0.1, -0.8, 1, 0.3, 0).finished()),
                                se3_exp((Vector6() << 0.1, 0, 0.2, 2, 0, 0.1).finished())};
  Matrix6 covariance = Matrix6::Zero();
  covariance.diagonal() << 1e-4, 2e-4, 4e-4, 1e-4, 3e-4, 1e-4;
  OdometryDrift drift;
  Pose T = se3_exp((Vector6() << 1, 2, 0.3, 5, -4, 2).finished());
  drift.add({0}, T, covariance);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    T = T * steps[i];
    drift.add({static_cast<std::int64_t>(i) + 1}, T, covariance);
  }
  Matrix6 sampled = Matrix6::Zero();
  const Matrix6 root = covariance.llt().matrixL();
  const int walks = 4000;
  for (int w = 0; w < walks; ++w) {
    Pose clean;
    Pose noisy;
    for (const Pose& step : steps) {
      clean = clean * step;
      noisy = noisy * step * se3_exp(root * random_vector(random, 1, 1));
    }
    const Vector6 error = se3_log(clean.inverse() * noisy);
    sampled += error * error.transpose() / walks;
  }
  const Matrix6 expected = drift.between({0}, {3});
  EXPECT_LT((expected - sampled).norm(), 0.08 * expected.norm());
  EXPECT_EQ(drift.between({2}, {2}), Matrix6::Zero());
  EXPECT_EQ(drift.between({9}, {2}), Matrix6::Zero());
}

}  // namespace
}  // namespace sgraph
