#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "sgraph_slam/core/registration/rigid_alignment.hpp"

namespace sgraph {
namespace {

const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();

Surface leaning(double degrees) {
  Surface surface;
  const double angle = degrees * M_PI / 180;
  surface.normal = {std::cos(angle), 0, std::sin(angle)};
  surface.mean = {-2, 1, 0.5};
  surface.offset = -surface.normal.dot(surface.mean);
  return surface;
}

TEST(Plumb, AWallStandsUprightThroughItsMiddle) {
  const auto wall = plumb(leaning(5), up);
  ASSERT_TRUE(wall);
  EXPECT_NEAR(wall->normal.z(), 0, 1e-12);
  EXPECT_NEAR(wall->normal.norm(), 1, 1e-12);
  EXPECT_NEAR(wall->distance(leaning(5).mean), 0, 1e-12);
}

TEST(Plumb, AFloorStaysAndWhatIsNeitherIsLeftOut) {
  EXPECT_EQ(plumb(leaning(88), up)->normal, leaning(88).normal);
  EXPECT_FALSE(plumb(leaning(45), up));
}

// Four walls seen as stripes that lean, as a cabin shows them: their lean would lift the sensor.
TEST(Plumb, StripesThatLeanDontMoveTheSensorUp) {
  SurfaceMap map{SurfaceMapParams{}};
  const Eigen::Vector3d sensor(0.1, 0.05, 0.1);
  std::vector<SeenPoint> points;
  for (int round = 0; round < 3; ++round) {
    for (double along = -0.9; along < 0.9; along += 0.05) {
      for (double z = -0.2; z <= 0.2; z += 0.05) {
        for (const Eigen::Vector3d& p : {Eigen::Vector3d(1 + 0.06 * z, along, z), Eigen::Vector3d(-1 - 0.06 * z, along, z),
                                         Eigen::Vector3d(along, 1 + 0.06 * z, z), Eigen::Vector3d(along, -1 - 0.06 * z, z)}) {
          map.insert(p, sensor);
          if (round == 0) points.push_back({p + Eigen::Vector3d(0.03, -0.02, 0.1), sensor + Eigen::Vector3d(0.03, -0.02, 0.1)});
        }
      }
    }
  }
  map.update();
  RigidAlignmentOptions options;
  options.plumb_along = up;
  const RigidAlignmentResult result = align_rigidly(map, points, options);
  EXPECT_NEAR(result.moved.x(), -0.03, 0.005);
  EXPECT_NEAR(result.moved.y(), 0.02, 0.005);
  EXPECT_NEAR(result.moved.z(), 0, 1e-6);
  EXPECT_NEAR((result.held * (Vector6() << 0, 0, 0, 0, 0, 1).finished()).norm(), 0, 1e-9);
}

}  // namespace
}  // namespace sgraph
