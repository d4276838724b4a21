// Mixed pixels: what floats between two surfaces is dropped, what is thin or seen at a grazing angle stays.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "sgraph_slam/core/prefilter/prefilter.hpp"

namespace sgraph {
namespace {

constexpr double step = 0.2 * M_PI / 180;  // between firings [rad]

// A turn of 16 rings, 2 degrees apart, over surfaces whose horizontal distance at an azimuth is given; with the noise of a range.
Cloud turn(const std::function<double(double)>& distance, double sigma) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 1);
  Cloud cloud;
  for (int firing = -450; firing < 450; ++firing) {
    const double azimuth = step * firing;
    for (int ring = 0; ring < 16; ++ring) {
      const double elevation = (2 * ring - 15) * M_PI / 180;
      const double range = distance(azimuth) / std::cos(elevation) + sigma * noise(random);
      Point p;
      p.set_position((range * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)))
                         .cast<float>());
      p.time = static_cast<float>(1e-4 * firing);
      p.ring = static_cast<std::uint16_t>(ring);
      cloud.points.push_back(p);
    }
  }
  return cloud;
}

int mixed(const Cloud& cloud) {
  PrefilterParams params;
  params.leaf = 0;
  return Prefilter(params).process(cloud).counts.mixed;
}

double wall(double azimuth) { return 4 / std::max(0.05, std::cos(azimuth)); }  // 4 m ahead, seen at grazing angles far aside

// Points that the noise may cost, of 14 400: where a surface seen at a grazing angle makes steps that are hardly larger than the noise.
constexpr int by_noise = 15;

// A cabinet 2 m before the wall from -0.3 to 0.3 rad, and the beam at each of its edges somewhere between the two.
double wall_behind_cabinet(double azimuth, double share) {
  const double edge = std::min(std::abs(azimuth - 0.3), std::abs(azimuth + 0.3));
  const double cabinet = 2 / std::cos(azimuth);
  if (edge < 0.5 * step) return cabinet + share * (wall(azimuth) - cabinet);
  return std::abs(azimuth) < 0.3 ? cabinet : wall(azimuth);
}

TEST(MixedPixels, WhatFloatsAtAnEdgeIsDropped) {
  for (const double share : {0.1, 0.3, 0.5, 0.9}) {
    EXPECT_EQ(mixed(turn([&](double azimuth) { return wall_behind_cabinet(azimuth, share); }, 0)), 2 * 16) << share;
    EXPECT_NEAR(mixed(turn([&](double azimuth) { return wall_behind_cabinet(azimuth, share); }, 0.01)), 2 * 16, by_noise) << share;
  }
}

TEST(MixedPixels, AnEdgeWithoutOneLosesNothing) {
  for (const double sigma : {0.0, 0.01, 0.02}) {
    const auto edge = [](double azimuth) { return wall_behind_cabinet(azimuth, 0); };
    EXPECT_LE(mixed(turn(edge, sigma)), sigma > 0 ? by_noise : 0) << sigma;
  }
}

TEST(MixedPixels, AWallSeenAtAGrazingAngleStays) {
  EXPECT_EQ(mixed(turn(wall, 0)), 0);
  EXPECT_LE(mixed(turn(wall, 0.02)), by_noise);
  // A corridor of 60 m, from its middle: the far end of its wall is seen at two degrees.
  const auto corridor = [](double azimuth) {
    return std::min(30 / std::max(1e-3, std::cos(azimuth)), 1 / std::max(1e-3, std::abs(std::sin(azimuth))));
  };
  EXPECT_EQ(mixed(turn(corridor, 0)), 0);
  EXPECT_LE(mixed(turn(corridor, 0.02)), by_noise);
}

TEST(MixedPixels, ThinThingsStay) {
  // Legs and rails of one, two and three beams, a metre apart, before the wall.
  for (int beams = 1; beams <= 3; ++beams) {
    const auto posts = [beams](double azimuth) {
      const int firing = static_cast<int>(std::lround(azimuth / step));
      return (firing + 450) % 90 < beams ? 3.0 : wall(azimuth);
    };
    EXPECT_EQ(mixed(turn(posts, 0)), 0) << beams;
  }
}

TEST(MixedPixels, CloudsWithoutRingsLoseNothing) {
  Cloud cloud = turn([](double azimuth) { return wall_behind_cabinet(azimuth, 0.5); }, 0.01);
  for (Point& p : cloud.points) p.ring = 0;
  EXPECT_EQ(mixed(cloud), 0);
}

TEST(MixedPixels, StayWhenAskedFor) {
  PrefilterParams params;
  params.leaf = 0;
  params.keep_mixed_pixels = true;
  const Cloud cloud = turn([](double azimuth) { return wall_behind_cabinet(azimuth, 0.5); }, 0);
  EXPECT_EQ(Prefilter(params).process(cloud).counts.mixed, 0);
}

}  // namespace
}  // namespace sgraph
