#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/places/oriented_rectangle.hpp"
#include "sgraph_slam/core/planes/intervals.hpp"
#include "sgraph_slam/core/planes/outline.hpp"
#include "sgraph_slam/core/planes/wall.hpp"

namespace sgraph {
namespace {

// Against a line painted in steps of a centimetre.
TEST(Intervals, UniteClipAndGapsAgreeWithPainting) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> at(0, 999);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<bool> painted(1000, false);
    Intervals parts;
    for (int i = 0; i < 6; ++i) {
      const int a = at(random);
      const int b = a + at(random) / 10;
      parts.push_back({0.01 * a, 0.01 * b});
      for (int k = a; k < std::min(b, 1000); ++k) painted[static_cast<std::size_t>(k)] = true;
    }
    const Interval within{1.0, 8.0};
    const double solid = 0.01 * static_cast<double>(std::count(painted.begin() + 100, painted.begin() + 800, true));
    const Intervals united = unite(parts);
    EXPECT_NEAR(total_length(clip(united, within)), solid, 1e-9);
    EXPECT_NEAR(total_length(gaps(united, within)), 7.0 - solid, 1e-9);
    for (std::size_t i = 1; i < united.size(); ++i) EXPECT_GT(united[i].low, united[i - 1].high);
  }
}

TEST(Intervals, BridgeGaps) {
  EXPECT_EQ(unite({{0, 1}, {1.2, 2}}, 0.3).size(), 1U);
  EXPECT_EQ(unite({{0, 1}, {1.4, 2}}, 0.3).size(), 2U);
  EXPECT_TRUE(unite({{2, 1}, {1, 1}}).empty());
  EXPECT_EQ(hull({}).length(), 0);
}

Plane random_plane(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized(), 3 * normal(random)};
}

std::vector<Eigen::Vector3d> points_on(const Plane& plane, const Eigen::Vector2d& center, int count, std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(tangent_basis(plane.normal) * (center + Eigen::Vector2d(normal(random), normal(random))) - plane.d * plane.normal);
  }
  return points;
}

TEST(Outlines, HoldTheirPointsCounterClockwiseAboutTheNormal) {
  std::mt19937 random(2);
  for (int trial = 0; trial < 100; ++trial) {
    const Plane plane = random_plane(random);
    const auto points = points_on(plane, {5, -3}, 40, random);
    const Outline outline = convex_outline(plane, points);
    ASSERT_GE(outline.size(), 3U);
    for (std::size_t i = 0; i < outline.size(); ++i) {
      EXPECT_NEAR(plane.distance(outline[i]), 0, 1e-9);
      const Eigen::Vector3d edge = outline[(i + 1) % outline.size()] - outline[i];
      for (const auto& p : points) EXPECT_GT(plane.normal.dot(edge.cross(p - outline[i])), -1e-9);
    }
  }
}

TEST(Outlines, GrowAndStaySmall) {
  std::mt19937 random(3);
  const Plane plane = random_plane(random);
  Outline outline;
  double area = 0;
  for (int i = 0; i < 50; ++i) {
    outline = grown_outline(plane, outline, points_on(plane, {0.3 * i, 0}, 30, random));
    EXPECT_LE(outline.size(), 24U);
    EXPECT_GT(outline_area(outline), 0.98 * area);  // thinning corners costs little
    area = outline_area(outline);
  }
}

TEST(Outlines, DistanceAgreesWithSampling) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> shift(-6, 6);
  int apart = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Plane plane = random_plane(random);
    const Outline a = convex_outline(plane, points_on(plane, {0, 0}, 12, random));
    const Outline b = convex_outline(plane, points_on(plane, {shift(random), shift(random)}, 12, random));
    const double distance = outline_distance(plane, a, b);
    EXPECT_NEAR(distance, outline_distance(plane, b, a), 1e-12);
    double sampled = 1e9;  // between points along the edges
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (std::size_t k = 0; k < b.size(); ++k) {
        for (int s = 0; s < 20; ++s) {
          for (int t = 0; t < 20; ++t) {
            const Eigen::Vector3d p = a[i] + (a[(i + 1) % a.size()] - a[i]) * s / 20.0;
            const Eigen::Vector3d q = b[k] + (b[(k + 1) % b.size()] - b[k]) * t / 20.0;
            sampled = std::min(sampled, (p - q).norm());
          }
        }
      }
    }
    EXPECT_LE(distance, sampled + 1e-9);
    if (distance > 0) {
      ++apart;
      EXPECT_GT(distance, sampled - 0.3);
    }
  }
  EXPECT_GT(apart, 10);
  EXPECT_LT(apart, 55);
}

TEST(Outlines, AwkwardInputGivesNoNonsense) {
  const Plane floor{Eigen::Vector3d::UnitZ(), 0};
  EXPECT_TRUE(convex_outline(floor, {}).empty());
  EXPECT_EQ(convex_outline(floor, {{1, 1, 0}, {1, 1, 0}}).size(), 1U);
  EXPECT_EQ(convex_outline(floor, {{0, 0, 0}, {1, 1, 0}, {2, 2, 0}}).size(), 2U);
  EXPECT_TRUE(std::isinf(outline_distance(floor, {}, {{0, 0, 0}})));
  EXPECT_NEAR(outline_distance(floor, {{0, 0, 0}, {2, 2, 0}}, {{0, 2, 0}}), std::sqrt(2.0), 1e-12);
}

TEST(Rectangles, SharedAreaAgreesWithSampling) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 20; ++trial) {
    const auto draw = [&] {
      OrientedRectangle r;
      r.center = {3 * uniform(random), 3 * uniform(random)};
      r.size = {1 + 3 * uniform(random), 1 + 3 * uniform(random)};
      r.yaw = 7 * uniform(random);
      return r;
    };
    const OrientedRectangle a = draw();
    const OrientedRectangle b = draw();
    int both = 0;
    for (int i = 0; i < 200; ++i) {
      for (int k = 0; k < 200; ++k) {
        const Eigen::Vector2d p(-4 + 0.06 * i, -4 + 0.06 * k);
        both += a.contains(p) && b.contains(p) ? 1 : 0;
      }
    }
    EXPECT_NEAR(shared_area(a, b), both * 0.0036, 0.15);
    EXPECT_NEAR(shared_area(a, a), a.area(), 1e-9);
  }
}

TEST(Intervals, CoveredTakesWhatEnoughPartsSay) {
  const Intervals parts{{0, 4}, {1, 5}, {2, 3}, {8, 9}, {5, 7}, {3, 3}};
  const Intervals twice = covered(parts, 2);
  ASSERT_EQ(twice.size(), 1u);
  EXPECT_EQ(twice[0].low, 1);
  EXPECT_EQ(twice[0].high, 4);
  const Intervals once = covered(parts, 1);
  ASSERT_EQ(once.size(), 2u);
  EXPECT_EQ(once[0].high, 7);
  EXPECT_EQ(covered(parts, 3).size(), 1u);
  EXPECT_TRUE(covered(parts, 4).empty());
}

TEST(Wall, APieceThatOneViewInManyShowsIsNoWall) {
  const Plane plane{Eigen::Vector3d::UnitY(), 0};
  const auto view = [](double low, double high) { return std::vector<Eigen::Vector3d>{{low, 0, 0}, {high, 0, 0}, {high, 0, 2}, {low, 0, 2}}; };
  std::vector<std::vector<Eigen::Vector3d>> views(60, view(1, 2));
  views.push_back(view(-4, 3));
  const auto wall = make_wall({0}, plane, views, 0.26, 0.3);
  ASSERT_TRUE(wall);
  EXPECT_NEAR(total_length(wall->support), 1, 1e-9);
  EXPECT_NEAR(total_length(make_wall({0}, plane, {view(1, 2), view(-4, 3)}, 0.26, 0.3)->support), 7, 1e-9) << "of two, each counts";
}

}  // namespace
}  // namespace sgraph
