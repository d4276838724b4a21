#include "sgraph_slam/core/prefilter/prefilter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <tuple>

namespace sgraph {
namespace {

Point point(double x, double y, double z, double time = 0, int ring = 0) {
  Point p;
  p.x = static_cast<float>(x);
  p.y = static_cast<float>(y);
  p.z = static_cast<float>(z);
  p.time = static_cast<float>(time);
  p.ring = static_cast<std::uint16_t>(ring);
  return p;
}

bool same(const Point& a, const Point& b) {
  return std::tie(a.x, a.y, a.z, a.intensity, a.time, a.ring) == std::tie(b.x, b.y, b.z, b.intensity, b.time, b.ring);
}

// Points on a plane z = height under the sensor, with noise across it, in firing order of a spinning sensor (many a voxel).
Cloud floor_cloud(double height, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, sigma);
  Cloud cloud;
  cloud.stamp = Stamp::from_seconds(12.5);
  cloud.frame = "velodyne";
  for (int column = 0; column < 1800; ++column) {
    for (int ring = 0; ring < 16; ++ring) {
      const double azimuth = -2 * M_PI * column / 1800, radius = 0.8 + 0.3 * ring;
      cloud.points.push_back(point(radius * std::cos(azimuth), radius * std::sin(azimuth), height + noise(random), 1e-4 * column / 1.8 - 0.1, ring));
    }
  }
  return cloud;
}

double mean_z(const Cloud& cloud) {
  double sum = 0;
  for (const Point& p : cloud.points) sum += p.z;
  return sum / static_cast<double>(cloud.size());
}

TEST(Prefilter, CountsAddUpAndPointsStayAsTheyCame) {
  Cloud raw = floor_cloud(-0.7, 0.02, 1);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  raw.points[10].x = nan;
  raw.points[11].y = inf;
  raw.points[12].z = -inf;
  raw.points[13].time = nan;
  raw.points[14] = point(0, 0, 0);
  raw.points[15] = point(0.1, 0.2, 0.1);
  raw.points[16] = point(80, 0, 0);
  raw.points[17] = point(1e30, 1e30, 0);
  raw.points[18] = point(1e-30, 0, 0);
  const FilteredScan scan = Prefilter({}).process(raw);
  const PrefilterCounts& c = scan.counts;
  EXPECT_EQ(c.input, 28800);
  EXPECT_EQ(c.invalid, 5);
  EXPECT_EQ(c.out_of_range, 4);
  EXPECT_EQ(c.kept, static_cast<int>(scan.cloud->size()));
  EXPECT_EQ(c.input, c.invalid + c.out_of_range + c.mixed + c.voxel + c.outliers + c.kept);
  EXPECT_GT(c.voxel, 10000);
  EXPECT_EQ(scan.cloud->stamp, raw.stamp);
  EXPECT_EQ(scan.cloud->frame, raw.frame);
  auto next = raw.points.begin();
  for (const Point& p : scan.cloud->points) {
    next = std::find_if(next, raw.points.end(), [&](const Point& q) { return same(p, q); });
    ASSERT_NE(next, raw.points.end()) << "not a subset in order";
    ++next;
  }
}

TEST(Prefilter, WithoutThinningKeepsAllInRange) {
  PrefilterParams params;
  params.leaf = 0;
  const Cloud raw = floor_cloud(-0.7, 0.02, 2);
  const FilteredScan scan = Prefilter(params).process(raw);
  EXPECT_EQ(scan.cloud->size(), raw.size());
  EXPECT_EQ(scan.counts.voxel, 0);
}

TEST(Prefilter, RangeLimitsAreInclusive) {
  PrefilterParams params;
  params.min_range = 1;
  params.max_range = 2;
  Cloud raw;
  raw.points = {point(0.999, 0, 0), point(1, 0, 0), point(0, 2, 0), point(0, 0, 2.001)};
  const FilteredScan scan = Prefilter(params).process(raw);
  ASSERT_EQ(scan.cloud->size(), 2U);
  EXPECT_EQ(scan.counts.out_of_range, 2);
}

TEST(Prefilter, EveryVoxelKeepsOneOfItsPoints) {
  // Property: points of one voxel lie within its diagonal; so a dropped point has a kept one within sqrt(3) leaf, and the kept points of a dense
  // cloud on a plane number 1.4 to 1.75 a leaf^2. They stay in order.
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1.5, 1.5);
  for (int plane = 0; plane < 6; ++plane) {
    const double angle = 0.3 * plane;
    Cloud raw;
    for (int i = 0; i < 60000; ++i) {
      const double u = uniform(random), v = uniform(random);
      raw.points.push_back(plane == 0 ? point(u, v, -2)
                                      : point(4 * std::cos(angle) - u * std::sin(angle), 4 * std::sin(angle) + u * std::cos(angle), v, i));
    }
    PrefilterParams params;
    params.leaf = 0.1;
    const FilteredScan scan = Prefilter(params).process(raw);
    const double density = static_cast<double>(scan.cloud->size()) / 900;
    EXPECT_GT(density, 1.35);
    EXPECT_LT(density, 1.9);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < raw.size(); i += 1) {
      if (kept < scan.cloud->size() && same(raw.points[i], scan.cloud->points[kept])) {
        ++kept;
        continue;
      }
      if (i % 97 != 0) continue;
      bool covered = false;
      for (std::size_t k = 0; k < scan.cloud->size() && !covered; ++k) {
        covered = (scan.cloud->points[k].position() - raw.points[i].position()).norm() <= 0.1F * 1.7321F;
      }
      EXPECT_TRUE(covered);
    }
    EXPECT_EQ(kept, scan.cloud->size());
  }
}

TEST(Prefilter, ThinningTwiceChangesNothing) {
  const Prefilter prefilter({});
  const FilteredScan once = prefilter.process(floor_cloud(-0.7, 0.02, 5));
  const FilteredScan twice = prefilter.process(*once.cloud);
  EXPECT_EQ(twice.counts.voxel, 0);
  EXPECT_EQ(twice.cloud->size(), once.cloud->size());
}

TEST(Prefilter, ThinningDoesNotMoveAFloor) {
  // Heights around the boundary of a grid aligned with the floor, where keeping one point a cell would move it by up to half a sigma (1 cm).
  for (int i = -5; i <= 5; ++i) {
    const double height = -0.7 + 0.01 * i;
    const Cloud raw = floor_cloud(height, 0.02, static_cast<unsigned>(100 + i));
    EXPECT_NEAR(mean_z(*Prefilter({}).process(raw).cloud), height, 1.5e-3) << height;
  }
}

TEST(Prefilter, SigmaIntervalDropsFarAndNearRanges) {
  // Nine points at 3, 4 and 5 m: mean 4, sigma sqrt(2/3); one sigma keeps the three at 4 m.
  Cloud raw;
  for (int i = 0; i < 3; ++i) {
    for (int range = 3; range <= 5; ++range) raw.points.push_back(point(range * std::cos(i), range * std::sin(i), 0));
  }
  raw.points.push_back(point(90, 0, 0));  // beyond max_range: not in the statistics
  PrefilterParams params;
  params.range_sigmas = 1;
  const FilteredScan scan = Prefilter(params).process(raw);
  ASSERT_EQ(scan.cloud->size(), 3U);
  for (const Point& p : scan.cloud->points) EXPECT_NEAR(p.position().norm(), 4, 1e-5);
  EXPECT_EQ(scan.counts.out_of_range, 7);
}

TEST(Prefilter, SigmaIntervalKeepsEqualRanges) {
  PrefilterParams params;
  params.range_sigmas = 3;
  Cloud raw;
  raw.points.assign(5, point(3, 0, 0));
  params.leaf = 0;
  EXPECT_EQ(Prefilter(params).process(raw).cloud->size(), 5U);
}

TEST(Prefilter, OutlierRemovalDropsLonelyPointsAlone) {
  Cloud raw = floor_cloud(-0.7, 0.005, 6);
  const std::size_t floor_points = Prefilter({}).process(raw).cloud->size();
  for (int i = 0; i < 5; ++i) raw.points.push_back(point(3 * std::cos(i), 3 * std::sin(i), 5 + 2 * i, 0.5));
  for (const char* kind : {"radius", "statistical"}) {
    PrefilterParams params;
    params.outliers = kind;
    params.outlier_neighbours = 3;
    params.outlier_sigmas = 6;
    const FilteredScan scan = Prefilter(params).process(raw);
    EXPECT_EQ(scan.counts.outliers, 5) << kind;
    EXPECT_EQ(scan.cloud->size(), floor_points) << kind;
    for (const Point& p : scan.cloud->points) EXPECT_LT(p.z, 0) << kind;
  }
}

TEST(Prefilter, EmptyAndUselessCloudsGiveEmptyClouds) {
  for (const char* kind : {"none", "radius", "statistical"}) {
    PrefilterParams params;
    params.outliers = kind;
    params.range_sigmas = 2;
    const Prefilter prefilter(params);
    EXPECT_TRUE(prefilter.process({}).cloud->empty());
    Cloud raw;
    raw.points.assign(100, point(0, 0, 0));
    EXPECT_TRUE(prefilter.process(raw).cloud->empty());
    raw.points = {point(1, 2, 3)};
    EXPECT_EQ(prefilter.process(raw).cloud->size(), 1U);
  }
}

TEST(Prefilter, RefusesParametersThatContradictEachOther) {
  PrefilterParams params;
  params.min_range = 70;
  EXPECT_THROW(Prefilter{params}, std::runtime_error);
  params = {};
  params.leaf = 1e-5;
  EXPECT_THROW(Prefilter{params}, std::runtime_error);
}

}  // namespace
}  // namespace sgraph
