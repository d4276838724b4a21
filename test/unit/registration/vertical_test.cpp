#include "sgraph_slam/core/registration/vertical.hpp"

#include <gtest/gtest.h>

#include "sgraph_slam/core/math/so3.hpp"
#include "support/noisy_box.hpp"

namespace sgraph {
namespace {

using Eigen::Vector3d;

using Sides = test::BoxSides;

// A room of 9 x 6 x 3 m around the sensor, turned.
SurfaceMap room(const Eigen::Quaterniond& turn, Sides sides) {
  SurfaceMap map({});
  for (const test::SidePoint& point : test::noisy_box({9, 6, 3}, sides, 60000, 0.01, 1)) map.insert(turn * point.position, Vector3d::Zero());
  map.update();
  return map;
}

double angle(const Vector3d& a, const Vector3d& b) { return std::acos(std::min(1.0, a.dot(b))); }

TEST(Vertical, IsFoundInATiltedRoomByFloorsOrByWalls) {
  for (const Vector3d& tilt : {Vector3d(0, 0, 0.5), Vector3d(0.25, 0, 0.3), Vector3d(-0.1, 0.2, 0)}) {
    const Eigen::Quaterniond turn = so3_exp(tilt);
    for (const Sides sides : {Sides{true, true}, Sides{true, false}, Sides{false, true}}) {
      const auto up = vertical_of(room(turn, sides), Vector3d::UnitZ());
      ASSERT_TRUE(up) << tilt.transpose();
      EXPECT_LT(angle(*up, turn * Vector3d::UnitZ()), 0.01) << tilt.transpose();
    }
  }
}

TEST(Vertical, IsUnknownWithoutSurfacesAndBetweenTwoParallelWalls) {
  EXPECT_FALSE(vertical_of(SurfaceMap({}), Vector3d::UnitZ()));
  EXPECT_FALSE(vertical_of(room(Eigen::Quaterniond::Identity(), {false, false}), Vector3d::UnitZ()));
}

}  // namespace
}  // namespace sgraph
