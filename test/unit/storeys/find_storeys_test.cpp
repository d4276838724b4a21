#include "sgraph_slam/core/storeys/find_storeys.hpp"

#include <gtest/gtest.h>

#include "sgraph_slam/core/types/storey.hpp"

namespace sgraph {
namespace {

// A path with a position every 0.75 m of way.
class Walk {
 public:
  Walk& to(double x, double y, double z) {
    const Eigen::Vector3d from = path.back();
    const Eigen::Vector3d goal(x, y, z);
    const int steps = std::max(1, static_cast<int>(std::ceil((goal - from).norm() / 0.75)));
    for (int i = 1; i <= steps; ++i) path.emplace_back(from + (goal - from) * i / steps);
    return *this;
  }
  // Two flights with a landing between them, 2.7 m long and 1.5 m high each, and a few steps away from them.
  Walk& stairs(double from, double to) {
    const double middle = 0.5 * (from + to);
    return this->to(0, 0, from).to(0, -2.7, middle).to(0, -3.7, middle).to(-1.4, -3.7, middle).to(-1.4, -2.7, middle).to(-1.4, 0, to);
  }

  std::vector<Eigen::Vector3d> path{{10, 5, 0}};
};

TEST(FindStoreys, KnowsTwoStoreysAndTheStairwellBetween) {
  Walk walk;
  walk.to(0, 5, 0).stairs(0, 3).to(0, 6, 3).to(9, 6, 3);
  const StoreysOfPath found = find_storeys(walk.path);
  ASSERT_EQ(found.heights.size(), 2U);
  EXPECT_NEAR(found.heights[1], 3, 0.05);
  for (std::size_t i = 0; i < walk.path.size(); ++i) {
    const double z = walk.path[i].z();
    EXPECT_EQ(found.storey[i], z < 0.1 ? 0 : z > 2.9 ? 1 : stairwell) << i << " at " << z;
  }
}

TEST(FindStoreys, ComesBackToTheFirstStoreyByOtherStairs) {
  Walk walk;
  walk.to(0, 5, 0).stairs(0, 3).to(0, 6, 3).to(20, 6, 3.1).to(20, 0, 3.1).to(20, -3, 1.5).to(20, -6, 0.1).to(10, -6, 0.1);
  const StoreysOfPath found = find_storeys(walk.path);
  EXPECT_EQ(found.heights.size(), 2U);
  EXPECT_EQ(found.storey.back(), 0);
}

TEST(FindStoreys, TakesAMezzanineASunkenRoomAndHalfALevelForPartsOfTheirStorey) {
  for (const double height : {1.6, -1.2, 1.4}) {
    Walk walk;
    walk.to(0, 5, 0).to(0, 5 - 1.7 * std::abs(height), height).to(6, 2, height).to(6, -4, height);
    const StoreysOfPath found = find_storeys(walk.path);
    EXPECT_EQ(found.heights.size(), 1U) << height;
    EXPECT_EQ(found.storey.back(), 0) << height;
  }
}

TEST(FindStoreys, TakesARampOfACarParkForTheWayBetweenItsStoreys) {
  Walk walk;
  walk.to(0, 5, 0).to(-28, 5, 2.8).to(-40, 5, 2.8).to(-40, 15, 2.8);  // 10 %
  const StoreysOfPath found = find_storeys(walk.path);
  ASSERT_EQ(found.heights.size(), 2U);
  EXPECT_NEAR(found.heights[1], 2.8, 0.1);
  EXPECT_EQ(found.storey[walk.path.size() / 2], stairwell);
}

TEST(FindStoreys, ALandingIsNone) {
  Walk walk;
  walk.to(0, 5, 0).stairs(0, 5.2).to(0, 6, 5.2).to(9, 6, 5.2);  // the landing is 2.6 m above the floor
  EXPECT_EQ(find_storeys(walk.path).heights.size(), 2U);
}

TEST(FindStoreys, WhoIsLiftedByHandStaysOnHisStorey) {
  Walk walk;
  walk.to(5, 5, 0);
  for (const double z : {0.4, 0.8, 1.2}) walk.path.emplace_back(5.1, 5, z);
  walk.to(2, 5, 1.2).to(2, 3, 1.2);
  for (const double z : {0.8, 0.4, 0.0}) walk.path.emplace_back(2, 2.9, z);
  walk.to(2, -5, 0);
  const StoreysOfPath found = find_storeys(walk.path);
  EXPECT_EQ(found.heights.size(), 1U);
  for (const int storey : found.storey) EXPECT_EQ(storey, 0);
}

TEST(FindStoreys, AFloorThatSlopesByCentimetresIsOne) {
  Walk walk;
  walk.to(0, 5, 0.1).to(-40, 5, 0.9).to(-40, -20, 0.4);  // 2 %
  const StoreysOfPath found = find_storeys(walk.path);
  EXPECT_EQ(found.heights.size(), 1U);
  for (const int storey : found.storey) EXPECT_EQ(storey, 0);
}

TEST(FindStoreys, ALiftLeadsToANewStoreyOfUnknownHeight) {
  Walk walk;
  walk.to(5, 0, 0);
  const std::size_t ride = walk.path.size();
  walk.to(5, 8, 0).to(0, 8, 0);
  const StoreysOfPath found = find_storeys(walk.path, {{ride, std::nullopt}});
  ASSERT_EQ(found.heights.size(), 2U);
  EXPECT_NE(found.group[0], found.group[1]);
  for (std::size_t i = 0; i < walk.path.size(); ++i) EXPECT_EQ(found.storey[i], i < ride ? 0 : 1);
}

TEST(FindStoreys, ALiftBackToTheFirstStoreyMakesNoThird) {
  Walk walk;
  walk.to(5, 0, 0);
  const std::size_t up = walk.path.size();
  walk.to(5, 8, 0).to(0, 8, 0).to(5, 8, 0).to(5, 0, 0);
  const std::size_t down = walk.path.size();
  walk.to(5, 6, 0).to(9, 6, 0);
  const StoreysOfPath found = find_storeys(walk.path, {{up, std::nullopt}, {down, 0}});
  EXPECT_EQ(found.heights.size(), 2U);
  EXPECT_EQ(found.storey[down - 1], 1);
  EXPECT_EQ(found.storey[down], 0);
  EXPECT_EQ(found.storey.back(), 0);
}

TEST(FindStoreys, StairsFromAStoreyReachedByALiftAreComparedWithThatOneAlone) {
  Walk walk;
  walk.to(0, 5, 0);
  const std::size_t ride = walk.path.size();
  walk.to(0, 6, 0).to(0, 5, 0).stairs(0, 3).to(0, 6, 3).to(9, 6, 3);
  const StoreysOfPath found = find_storeys(walk.path, {{ride, std::nullopt}});
  ASSERT_EQ(found.heights.size(), 3U);
  EXPECT_EQ(found.group[1], found.group[2]);
  EXPECT_NE(found.group[0], found.group[1]);
}

TEST(FindStoreys, NothingOfNothing) { EXPECT_TRUE(find_storeys({}).heights.empty()); }

}  // namespace
}  // namespace sgraph
