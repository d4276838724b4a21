#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sgraph_slam/core/prefilter/prefilter.hpp"

namespace sgraph {
namespace {

constexpr double half_width = 1.2;

// One clockwise turn of a single ring between the walls of a corridor along x.
Cloud corridor_scan(std::mt19937& random) {
  std::normal_distribution<double> noise(0, 0.02);
  Cloud cloud;
  for (int i = 0; i < 14400; ++i) {
    const double azimuth = -2 * M_PI * (i + 0.5) / 14400;
    const double range = half_width / std::abs(std::sin(azimuth)) + noise(random);
    if (range > 20) continue;
    Point p;
    p.x = static_cast<float>(range * std::cos(azimuth));
    p.y = static_cast<float>(range * std::sin(azimuth));
    cloud.points.push_back(p);
  }
  return cloud;
}

// By how much the walls of the corridor are turned, by least squares [rad].
double turn_of_walls(const Cloud& cloud) {
  double numerator = 0, denominator = 0;
  for (const Point& p : cloud.points) {
    const double x = p.x;
    numerator += x * (static_cast<double>(p.y) - std::copysign(half_width, static_cast<double>(p.y)));
    denominator += x * x;
  }
  return numerator / denominator;
}

// Of the points in a voxel the one kept must not depend on the way the beam sweeps: noise would turn the scan.
TEST(Prefilter, ThinningDoesNotTurnTheScanAgainstTheSweep) {
  std::mt19937 random(1);
  PrefilterParams params;
  params.max_range = 30;
  const Prefilter prefilter(params);
  double turn = 0;
  constexpr int scans = 200;
  for (int i = 0; i < scans; ++i) turn += turn_of_walls(*prefilter.process(corridor_scan(random)).cloud) / scans;
  EXPECT_LT(std::abs(turn), 2e-5);
}

}  // namespace
}  // namespace sgraph
