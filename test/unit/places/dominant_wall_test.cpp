#include "sgraph_slam/core/places/dominant_wall.hpp"

#include <gtest/gtest.h>

#include "support/plan.hpp"

namespace sgraph {
namespace {

const OrientedRectangle room{{3, 2}, {6, 4}, 0};
constexpr double coplanar = 0.12;
constexpr double parallel = 0.09;

// The +x side of a room of 6 m x 4 m and a second plane `depth` behind it, over the y from `low` to `high`.
struct TwoPlanes {
  Plan plan;
  PlaneId front;
  PlaneId back;
  TwoPlanes(double depth, double low, double high) {
    front = plan.add({6, 0}, {6, 4});
    back = plan.add({6 + depth, low}, {6 + depth, high});
  }
  [[nodiscard]] PlaneId from(PlaneId present) const { return dominant_wall(plan.walls, present, room, coplanar, parallel); }
};

TEST(DominantWall, AShelfsBackIsNotTheWallBehindIt) {
  const TwoPlanes planes(0.06, 0, 3.6);
  EXPECT_EQ(planes.from(planes.front), planes.back);
  EXPECT_EQ(planes.from(planes.back), planes.back);
}

TEST(DominantWall, APaneBehindTheWallIsNotTheWall) {
  const TwoPlanes planes(0.06, 1, 3);
  EXPECT_EQ(planes.from(planes.front), planes.front);
  EXPECT_EQ(planes.from(planes.back), planes.front);
}

TEST(DominantWall, OfTwinsThePresentOneStays) {
  const TwoPlanes planes(0.005, 0, 4);
  EXPECT_EQ(planes.from(planes.front), planes.front);
  EXPECT_EQ(planes.from(planes.back), planes.back);
}

TEST(DominantWall, AnotherWallFurtherOutIsNoneOfThisSide) {
  const TwoPlanes planes(0.3, 0, 4);
  EXPECT_EQ(planes.from(planes.front), planes.front);
}

}  // namespace
}  // namespace sgraph
