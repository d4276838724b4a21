#include "sgraph_slam/core/registration/vertical.hpp"

#include <gtest/gtest.h>

#include <random>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

using Eigen::Vector3d;

struct Sides {
  bool level = true;   // floor and ceiling
  bool across = true;  // the walls across the long ones
};

// A room of 9 x 6 x 3 m around the sensor, turned.
SurfaceMap room(const Eigen::Quaterniond& turn, Sides sides) {
  SurfaceMap map({});
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  std::normal_distribution<double> noise(0, 0.01);
  for (int i = 0; i < 60000; ++i) {
    const double a = unit(random);
    const double b = unit(random);
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    Vector3d p(9 * a, side * 3 + noise(random), 3 * b);
    if (i % 3 == 1 && sides.level) p = {9 * a, 6 * b, side * 1.5 + noise(random)};
    if (i % 3 == 2 && sides.across) p = {side * 4.5 + noise(random), 6 * a, 3 * b};
    map.insert(turn * p, Vector3d::Zero());
  }
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
