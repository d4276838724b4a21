#include "sgraph_slam/core/planes/passages.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sgraph {
namespace {

// Along y at x = 2, seen from the low side, turned and moved with everything else.
class Passages : public testing::TestWithParam<double> {
 protected:
  Eigen::Vector2d place(double x, double y) const {
    return Eigen::Vector2d(std::cos(GetParam()) * x - std::sin(GetParam()) * y, std::sin(GetParam()) * x + std::cos(GetParam()) * y);
  }
  // Stretches in y; the wall's own direction runs against y.
  Wall wall(const Intervals& along_y) const {
    Wall wall;
    wall.normal = place(-1, 0);
    wall.offset = 2;
    for (auto part = along_y.rbegin(); part != along_y.rend(); ++part) wall.support.push_back({-part->high, -part->low});
    return wall;
  }
  GroundPath through(double y) const { return GroundPath({place(-1, 0), place(1.5, y), place(2.3, y), place(5, y)}); }
};

TEST_P(Passages, AWallWithADoorKeepsTheRest) {
  Wall w = wall({{-5, 3}});
  open_passages(w, through(1));
  ASSERT_EQ(w.support.size(), 2U);
  EXPECT_NEAR(w.support[0].low, -3, 1e-12);
  EXPECT_NEAR(w.support[0].high, -1.4, 1e-12);
  EXPECT_NEAR(w.support[1].low, -0.6, 1e-12);
  EXPECT_NEAR(w.support[1].high, 5, 1e-12);
}

TEST_P(Passages, OfAWallAcrossACorridorNothingIsLeft) {
  Wall w = wall({{-0.85, 0.7}});
  open_passages(w, through(0));
  EXPECT_TRUE(w.support.empty());
}

TEST_P(Passages, WhereAGapIsKnownOrTheWayEndsBeforeTheWallNothingChanges) {
  Wall w = wall({{-5, 0.4}, {1.4, 3}});
  const Intervals before = w.support;
  open_passages(w, through(0.9));
  open_passages(w, GroundPath({place(0, -2), place(1.9, -2), place(0, -3)}));
  ASSERT_EQ(w.support.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(w.support[i].low, before[i].low);
    EXPECT_EQ(w.support[i].high, before[i].high);
  }
}

INSTANTIATE_TEST_SUITE_P(AtHeadings, Passages, testing::Values(0.0, 0.7, 2.5));

}  // namespace
}  // namespace sgraph
