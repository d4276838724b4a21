#include "sgraph_slam/core/registration/level_planes.hpp"

#include <gtest/gtest.h>

#include <random>

namespace sgraph {
namespace {

using Eigen::Vector3d;

Surface level(double x, double y, double z, double normal_z = 1) {
  Surface surface;
  surface.mean = {x, y, z};
  surface.normal = {0, 0, normal_z};
  surface.offset = -normal_z * z;
  return surface;
}

// A floor of so many metres a side around the origin, at -0.7 m; with something level of one square metre on it.
LevelPlanes floor(double side) {
  std::vector<Surface> surfaces{level(0.5, 0.5, 0), level(1.5, 0.5, 0)};
  for (double x = 0.5 - side / 2; x < side / 2; x += 1) {
    for (double y = 0.5 - side / 2; y < side / 2; y += 1) surfaces.push_back(level(x, y, -0.7));
  }
  LevelPlanes planes;
  planes.find(surfaces, Vector3d::UnitZ());
  return planes;
}

TEST(LevelPlanes, FindsFloorsAndNoFurnitureAndEachOnce) {
  EXPECT_EQ(floor(3).size(), 0U);
  LevelPlanes planes = floor(6);
  EXPECT_EQ(planes.size(), 1U);
  std::vector<Surface> more;
  for (int i = 0; i < 40; ++i) more.push_back(level(i, 3, -0.71));
  planes.find(more, Vector3d::UnitZ());
  EXPECT_EQ(planes.size(), 1U);
  for (Surface& surface : more) surface = level(surface.mean.x(), 3, 2.1, -1);
  planes.find(more, Vector3d::UnitZ());
  EXPECT_EQ(planes.size(), 2U) << "a ceiling";
}

TEST(LevelPlanes, TakesWhatAFarRingSaysOfTheFloorForLessThanWhatANearOneDoes) {
  LevelPlanes planes = floor(20);
  const Vector3d sensor(0, 0, 0);
  const double far = planes.settle({10, 0, -0.69}, sensor, 0.01).z();
  const double near = planes.settle({2, 0, -0.69}, sensor, 0.01).z();
  EXPECT_LT(far, -0.694);
  EXPECT_GT(near, -0.695);
  EXPECT_LT(near, -0.690);
}

TEST(LevelPlanes, LeavesAloneWhatIsNotTheFloor) {
  LevelPlanes planes = floor(20);
  for (const double height : {-0.6, -0.3, 0.5, -0.8}) {
    const Vector3d p(8, 1, height);
    EXPECT_EQ(planes.settle(p, Vector3d::Zero(), 0.01), p) << height;
  }
}

TEST(LevelPlanes, LearnsHowTheFloorLeans) {
  LevelPlanes planes = floor(8);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> at(-15, 15);
  const Vector3d slope(0.001, -0.0005, 0);
  for (int i = 0; i < 20000; ++i) {
    Vector3d p(at(random), at(random), 0);
    p.z() = -0.7 + slope.dot(p);
    EXPECT_LT((planes.settle(p, p + Vector3d(1, 0, 0.7), 0.01) - p).norm(), 0.05);
    if (i % 1000 == 0) planes.update();
  }
  planes.update();
  const Vector3d p(14, 0, -0.7 + 0.014);
  EXPECT_NEAR(planes.settle(p, Vector3d::Zero(), 0.01).z(), p.z(), 0.0015);
}

}  // namespace
}  // namespace sgraph
