#include "sgraph_slam/core/registration/rigid_alignment.hpp"

#include <gtest/gtest.h>

#include <random>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

using Eigen::Vector3d;

const Vector3d sensor(0.3, -0.2, 1.1);

// Points on the inner surfaces of a box from (-length/2, -2, 0) to (length/2, 2, 2.5); without its ends a corridor.
std::vector<Vector3d> box(double length, bool ends, std::uint32_t seed, int count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  std::normal_distribution<double> noise(0, 0.01);
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double a = unit(random);
    const double b = unit(random);
    const double n = noise(random);
    switch (i % (ends ? 6 : 4)) {
      case 0: points.emplace_back(length * a, -2.03 + n, 1.25 + 2.5 * b); break;
      case 1: points.emplace_back(length * a, 2.04 + n, 1.25 + 2.5 * b); break;
      case 2: points.emplace_back(length * a, 4 * b, 0.02 + n); break;
      case 3: points.emplace_back(length * a, 4 * b, 2.53 + n); break;
      case 4: points.emplace_back(-0.5 * length - 0.02 + n, 4 * a, 1.25 + 2.5 * b); break;
      default: points.emplace_back(0.5 * length + 0.03 + n, 4 * a, 1.25 + 2.5 * b); break;
    }
  }
  return points;
}

SurfaceMap map_of(const std::vector<Vector3d>& points) {
  SurfaceMap map({});
  for (const Vector3d& p : points) map.insert(p, sensor);
  map.update();
  return map;
}

std::vector<SeenPoint> seen(const std::vector<Vector3d>& points, const Pose& moved) {
  std::vector<SeenPoint> all;
  for (const Vector3d& p : points) all.push_back({moved * p, moved * sensor});
  return all;
}

TEST(RigidAlignment, UndoesSeededPerturbations) {
  const SurfaceMap map = map_of(box(6, true, 1, 30000));
  const auto scan = box(6, true, 2, 2400);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 60; ++i) {
    Vector6 xi;
    for (int k = 0; k < 6; ++k) xi[k] = (k < 3 ? 0.04 : 0.12) * normal(random);
    const Pose moved = se3_exp(xi);
    const RigidAlignmentResult result = align_rigidly(map, seen(scan, moved), {});
    const Pose left = result.correction * moved;
    EXPECT_LT((left * sensor - sensor).norm(), 0.004) << i;
    EXPECT_LT(so3_log(left.rotation).norm(), 0.002) << i;
    EXPECT_EQ(result.held_directions, 6);
    EXPECT_GT(result.inlier_share, 0.85);
  }
}

TEST(RigidAlignment, LeavesTheDirectionAlongACorridorToThePrediction) {
  const SurfaceMap map = map_of(box(12, false, 4, 40000));
  const auto scan = box(12, false, 5, 2400);
  const Pose moved{so3_exp({0, 0, 0.03}), Vector3d(0.2, 0.1, 0.05)};
  const RigidAlignmentResult result = align_rigidly(map, seen(scan, moved), {});
  const Pose left = result.correction * moved;
  const Vector3d off = left * sensor - moved * sensor;
  EXPECT_LT(so3_log(left.rotation).norm(), 0.002);
  EXPECT_NEAR((left * sensor - sensor).y(), 0, 0.004);
  EXPECT_NEAR((left * sensor - sensor).z(), 0, 0.004);
  EXPECT_NEAR(off.x(), 0, 0.03) << "the data doesn't hold x";
  ASSERT_EQ(result.free_directions.size(), 1U);
  EXPECT_GT(std::abs(result.free_directions[0][3]), 0.95);
}

// Plaster isn't flat: the Gaussians' normals are off by a degree or two, and thousands of points on them must not hold what no wall holds.
TEST(RigidAlignment, UnevenWallsDoNotHoldTheDirectionAlongACorridor) {
  const auto uneven = [](std::vector<Vector3d> points) {
    for (Vector3d& p : points) p.y() += 0.012 * std::sin(2.1 * p.x() + 0.7 * p.z()) * (p.y() > 0 ? 1 : -0.8);
    return points;
  };
  const SurfaceMap map = map_of(uneven(box(24, false, 4, 80000)));
  const auto scan = uneven(box(20, false, 5, 8000));
  const Pose moved{so3_exp({0, 0, 0.01}), Vector3d(0.3, 0.05, 0.02)};
  const RigidAlignmentResult result = align_rigidly(map, seen(scan, moved), {});
  ASSERT_EQ(result.free_directions.size(), 1U);
  EXPECT_GT(std::abs(result.free_directions[0][3]), 0.95);
  const Vector3d off = result.correction * (moved * sensor) - moved * sensor;
  EXPECT_NEAR(off.x(), 0, 0.03) << "left to the prediction";
}

TEST(RigidAlignment, WithoutAMapNothingMoves) {
  const SurfaceMap map({});
  const RigidAlignmentResult result = align_rigidly(map, seen(box(6, true, 2, 500), {}), {});
  EXPECT_EQ(result.inlier_share, 0);
  EXPECT_EQ(result.held_directions, 0);
  EXPECT_LT(se3_log(result.correction).norm(), 1e-12);
}

}  // namespace
}  // namespace sgraph
