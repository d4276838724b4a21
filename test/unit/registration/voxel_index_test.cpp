#include "sgraph_slam/core/math/voxel_index.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <map>
#include <random>
#include <tuple>

namespace sgraph {
namespace {

TEST(VoxelIndex, AgreesWithAMapOfIntegerCoordinates) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> coordinate(-40, 40);
  const double edge = 0.5;
  VoxelIndex index(edge);
  std::map<std::tuple<int, int, int>, std::uint32_t> reference;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d p(coordinate(random), coordinate(random), 0.1 * coordinate(random));
    const Eigen::Vector3d g = VoxelIndex::in_grid(p) / edge;
    const auto cell = std::make_tuple(static_cast<int>(std::floor(g.x())), static_cast<int>(std::floor(g.y())), static_cast<int>(std::floor(g.z())));
    const auto known = reference.find(cell);
    EXPECT_EQ(index.find(index.key(p)), known == reference.end() ? VoxelIndex::none : known->second);
    const auto expected = reference.emplace(cell, static_cast<std::uint32_t>(reference.size())).first->second;
    EXPECT_EQ(index.find_or_add(index.key(p)), expected);
  }
  EXPECT_EQ(index.size(), reference.size());
}

TEST(VoxelIndex, TheGridIsARotationThatNoWallLiesAlong) {
  Eigen::Matrix3d axes;
  for (int k = 0; k < 3; ++k) axes.col(k) = VoxelIndex::in_grid(Eigen::Vector3d::Unit(k));
  EXPECT_LT((axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm(), 1e-7);
  EXPECT_NEAR(axes.determinant(), 1, 1e-7);
  // Floors, and walls at any heading, stay at least 35 degrees away from the grid's planes.
  EXPECT_LT(axes.col(2).cwiseAbs().maxCoeff(), 0.82);
  for (int i = 0; i < 90; ++i) {
    const Eigen::Vector3d wall(std::cos(0.0175 * i), std::sin(0.0175 * i), 0);
    EXPECT_LT((axes * wall).cwiseAbs().maxCoeff(), 0.82);
  }
}

}  // namespace
}  // namespace sgraph
