#include "sgraph_slam/core/places/free_space.hpp"

#include <iterator>

#include <gtest/gtest.h>

#include "scanned_plan.hpp"

namespace sgraph {
namespace {

TEST(FreeSpace, MarksOfAKeyframeMoveWithIt) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {6, 0}, {6, 4}, {0, 4}});
  scanned.walk({{1, 1}, {5, 3}});
  FreeSpace moved = scanned.space;
  std::map<KeyframeId, Pose> poses = scanned.poses;
  for (auto& [id, pose] : poses) pose.translation.x() += 0.4;
  moved.update(poses, 0);
  EXPECT_TRUE(moved.at({6.2, 2.0}).free());
  EXPECT_FALSE(scanned.space.at({6.2, 2.0}).free());
  moved.update(scanned.poses, 0);
  for (double x = -1; x < 7; x += 0.05) {
    for (double y = -1; y < 5; y += 0.05) {
      ASSERT_EQ(moved.at({x, y}).low, scanned.space.at({x, y}).low);
      ASSERT_EQ(moved.at({x, y}).hits, scanned.space.at({x, y}).hits);
    }
  }
}

// A state to come back to has no raster until it is come back to.
TEST(FreeSpace, ACopyMakesItsRasterAnew) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {6, 0}, {6, 4}, {0, 4}});
  scanned.walk({{1, 1}, {5, 3}, {1, 1}});
  const FreeSpace copy = scanned.space;
  EXPECT_EQ(copy.width(), 0);
  EXPECT_FALSE(copy.at({3, 1.5}).free());
  FreeSpace again = copy;  // of what has none itself
  again.update(scanned.poses, 0);
  ASSERT_EQ(again.width(), scanned.space.width());
  ASSERT_EQ(again.origin(), scanned.space.origin());
  int seen = 0;
  for (double x = -1; x < 7; x += 0.05) {
    for (double y = -1; y < 5; y += 0.05) {
      const FreeCell& a = again.at({x, y});
      const FreeCell& b = scanned.space.at({x, y});
      ASSERT_TRUE(a.low == b.low && a.mid == b.mid && a.high == b.high && a.over == b.over && a.hits == b.hits) << x << ' ' << y;
      seen += a.seen_through() ? 1 : 0;
    }
  }
  EXPECT_GT(seen, 1000);
  for (int y = 0; y < again.height(); ++y) {
    for (int x = 0; x < again.width(); ++x) {
      const Eigen::Vector2d middle = again.origin() + again.resolution() * Eigen::Vector2d(x + 0.5, y + 0.5);
      ASSERT_EQ(again.free_cells().at(x, y), again.at(middle).free());
    }
  }
}

// Marking ahead is the same work at another time, also for a copy that has no raster yet.
TEST(FreeSpace, MarksAheadWhatIsSettled) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {6, 0}, {6, 4}, {0, 4}});
  scanned.walk({{1, 1}, {5, 3}});
  FreeSpace space{FreeSpaceParams{}};
  for (const auto& [id, cloud] : scanned.clouds) space.add(id, cloud, Pose{});
  const auto all = [&](KeyframeId id) { return &scanned.poses.at(id); };
  space.mark_ahead(all, 100);
  EXPECT_EQ(space.width(), 0);  // nobody knows where the floor is
  space.update({*scanned.poses.begin()}, 0);
  const int before = space.at({3, 1.5}).low;
  const KeyframeId second = std::next(scanned.poses.begin())->first;
  space.mark_ahead([&](KeyframeId id) { return id == second ? &scanned.poses.at(id) : nullptr; }, 100);
  EXPECT_EQ(space.at({3, 1.5}).low, before + 1);
  space.mark_ahead(all, 1);
  FreeSpace copy = space;
  for (FreeSpace* each : {&space, &copy}) {
    each->mark_ahead(all, 1);
    EXPECT_GT(each->width(), 0);
    each->update(scanned.poses, 0);
    for (double x = -1; x < 7; x += 0.05) {
      for (double y = -1; y < 5; y += 0.05) {
        ASSERT_EQ(each->at({x, y}).low, scanned.space.at({x, y}).low);
        ASSERT_EQ(each->at({x, y}).hits, scanned.space.at({x, y}).hits);
      }
    }
  }
}

// Whoever walks to and fro for hours keeps what was seen last, not all of it.
TEST(FreeSpace, GrowsWithTheAreaAndNotWithTheTime) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {6, 0}, {6, 4}, {0, 4}});
  const auto visits = [&scanned](int times) {
    for (int i = 0; i < times; ++i) scanned.walk({{1, 1}, {5, 3}, {1, 1}});
    return scanned.space.at({3, 1.5}).low;
  };
  const int few = visits(3);
  const int enough = visits(9);
  EXPECT_GT(enough, few);
  EXPECT_LE(visits(12), enough + 2);
  EXPECT_TRUE(scanned.space.at({3, 1.5}).free());
  EXPECT_GT(scanned.space.at({6.01, 2}).hits, 0);
}

}  // namespace
}  // namespace sgraph
