#include "sgraph_slam/core/registration/ring_image.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sgraph {
namespace {

constexpr double height = 0.7;  // of the sensor above the floor [m]
constexpr double wall = 6.5;    // in front of it, at x [m]

// What 16 rings from -15 to 15 degrees see of a floor and a wall; rings numbered from the lowest or from the highest.
Cloud scan(bool from_highest) {
  Cloud cloud;
  for (int row = 0; row < 16; ++row) {
    const double elevation = (2.0 * row - 15.0) * M_PI / 180;
    for (int i = 0; i < 1800; ++i) {
      const double azimuth = i * M_PI / 900;
      const double to_floor = elevation < 0 ? height / std::tan(-elevation) : 1e9;
      const double to_wall = std::cos(azimuth) > 0 ? wall / std::cos(azimuth) : 1e9;
      const double reach = std::min(to_floor, to_wall);
      if (reach > 30) continue;
      Point point;
      point.x = static_cast<float>(reach * std::cos(azimuth));
      point.y = static_cast<float>(reach * std::sin(azimuth));
      point.z = static_cast<float>(reach * std::tan(elevation));
      point.ring = static_cast<std::uint16_t>(from_highest ? 15 - row : row);
      cloud.points.push_back(point);
    }
  }
  return cloud;
}

TEST(RingImage, TellsFloorFromWallByTheRingsBeside) {
  for (const bool from_highest : {false, true}) {
    const Cloud cloud = scan(from_highest);
    const RingImage image(cloud);
    int floor = 0;
    int edge = 0;
    for (const Point& point : cloud.points) {
      const auto normal = image.normal(point);
      if (!normal) continue;
      const bool on_floor = std::abs(point.z + height) < 1e-3;
      floor += on_floor;
      edge += (on_floor ? std::abs(normal->z()) : std::abs(normal->x())) < 0.99;
    }
    EXPECT_GT(floor, 3000);
    EXPECT_EQ(edge, 0);
  }
}

TEST(RingImage, SaysNothingWhereTheRingsLieCloseOrAreUnknown) {
  Cloud cloud = scan(false);
  const RingImage image(cloud);
  for (const Point& point : cloud.points) {
    const double lowest = height / std::tan(15.0 * M_PI / 180);
    if (point.ring == 0 && std::hypot(point.x, point.y) < lowest + 0.01) {
      EXPECT_FALSE(image.normal(point));
    }
  }
  for (Point& point : cloud.points) point.ring = 0;
  const RingImage unknown(cloud);
  for (const Point& point : cloud.points) ASSERT_FALSE(unknown.normal(point));
  EXPECT_FALSE(RingImage(Cloud{}).normal(Point{}));
}

}  // namespace
}  // namespace sgraph
