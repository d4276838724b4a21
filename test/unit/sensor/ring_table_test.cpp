#include "sgraph_slam/core/sensor/ring_table.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/spinning_lidar.hpp"

namespace sgraph {
namespace {

using test::SpinningLidar;

RingTable table_of(const SpinningLidar& lidar) { return *table_by_ring(lidar.scan(100)); }

TEST(RingTable, ModelsByTheirAngles) {
  SpinningLidar lidar;
  EXPECT_EQ(model_of(table_of(lidar)), "VLP-16");
  lidar.elevations_deg = SpinningLidar::evenly(-10, 10, 16);
  EXPECT_EQ(model_of(table_of(lidar)), "VLP-16 Hi-Res");
  lidar.elevations_deg = SpinningLidar::evenly(-30.67, 10.67, 32);
  EXPECT_EQ(model_of(table_of(lidar)), "HDL-32E");
  lidar.elevations_deg = SpinningLidar::evenly(-16, 15, 32);
  EXPECT_EQ(model_of(table_of(lidar)), "XT-32");
  lidar.elevations_deg = SpinningLidar::evenly(-45, 45, 64);
  EXPECT_EQ(model_of(table_of(lidar)), "OS0-64");
  lidar.elevations_deg = SpinningLidar::evenly(-16.6, 16.6, 16);
  EXPECT_EQ(model_of(table_of(lidar)), "OS1-16");
  lidar.elevations_deg = {-25,   -15.639, -11.31, -8.843, -7.254, -6.148, -5.333, -4.667, -4,     -3.667, -3.333,
                          -3,    -2.667,  -2.333, -2,     -1.667, -1.333, -1,     -0.667, -0.333, 0,      0.333,
                          0.667, 1,       1.333,  1.667,  2.333,  3.333,  4.667,  7,      10.333, 15};
  EXPECT_EQ(model_of(table_of(lidar)), "VLP-32C");
  lidar.elevations_deg = SpinningLidar::evenly(-20, 5, 12);
  EXPECT_EQ(model_of(table_of(lidar)), "unknown, 12 rings");
}

TEST(RingTable, OffsetsOfTheOrigins) {
  SpinningLidar lidar;
  EXPECT_TRUE(table_of(lidar).from_one_point);
  for (const double e : lidar.elevations_deg) lidar.vertical_offsets.push_back(-0.0419 * std::tan(e * M_PI / 180));
  const RingTable table = table_of(lidar);
  EXPECT_FALSE(table.from_one_point);
  EXPECT_TRUE(table.sharp);
  EXPECT_EQ(model_of(table), "VLP-16");
  for (std::size_t ring = 0; ring < 16; ++ring) EXPECT_NEAR(table.cones[ring].offset, vlp16_vertical_offsets()[ring], 2e-4);
  for (double& offset : lidar.vertical_offsets) offset *= 0.0365 / 0.0419;
  EXPECT_EQ(model_of(table_of(lidar)), "RS-16");
}

TEST(RingTable, ByElevationTheSameAsByRing) {
  for (const auto& angles : {SpinningLidar::vlp16(), SpinningLidar::evenly(-22.5, 22.5, 64), SpinningLidar::evenly(-45, 45, 128)}) {
    SpinningLidar lidar;
    lidar.elevations_deg = angles;
    const Cloud cloud = lidar.scan(100);
    const auto table = table_by_elevation(cloud);
    ASSERT_TRUE(table);
    ASSERT_EQ(table->rows(), static_cast<int>(angles.size()));
    int wrong = 0;
    for (const Point& p : cloud.points) wrong += table->nearest_row(p) != p.ring;
    EXPECT_EQ(wrong, 0);
  }
}

TEST(RingTable, NoTableWithoutBeams) {
  Cloud cloud;
  EXPECT_FALSE(table_by_ring(cloud));
  EXPECT_FALSE(table_by_elevation(cloud));
  for (int i = 0; i < 20000; ++i) {
    Point p;
    p.set_position({5 * std::cos(0.1F * static_cast<float>(i)), 5 * std::sin(0.1F * static_cast<float>(i)), std::sin(0.37F * static_cast<float>(i))});
    cloud.points.push_back(p);
  }
  EXPECT_FALSE(table_by_elevation(cloud));
}

}  // namespace
}  // namespace sgraph
