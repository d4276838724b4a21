#include "sgraph_slam/core/sensor/stamp_filter.hpp"

#include <gtest/gtest.h>

namespace sgraph {
namespace {

struct Passed {
  std::vector<double> stamps;
  int dropped;
};

// Scans with these stamps, received 0.1 s apart, or at the given times.
Passed passed(const std::vector<double>& stamps, StampFilter::Backward backward = StampFilter::Backward::restamps,
              const std::vector<double>& received = {}) {
  StampFilter filter(backward);
  Passed result;
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    auto cloud = std::make_shared<Cloud>();
    cloud->stamp = Stamp::from_seconds(stamps[i]);
    const double time = received.empty() ? 0.1 * static_cast<double>(i) : received[i];
    for (const CloudPtr& scan : filter.push(cloud, Stamp::from_seconds(time))) result.stamps.push_back(scan->stamp.seconds());
  }
  filter.finish();
  result.dropped = filter.dropped();
  return result;
}

void expect_near(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-6);
}

TEST(StampFilter, GoodStampsPassAtOnce) { expect_near(passed({1, 1.1, 1.2}).stamps, {1, 1.1, 1.2}); }

TEST(StampFilter, AStampFarInTheFutureIsDropped) {
  const Passed one = passed({1, 1.1, 1e6, 1.3, 1.4});
  expect_near(one.stamps, {1, 1.1, 1.3, 1.4});
  EXPECT_EQ(one.dropped, 1);
  const Passed two = passed({1, 1.1, 1e6, 2e6, 1.4, 1.5});
  expect_near(two.stamps, {1, 1.1, 1.4, 1.5});
  EXPECT_EQ(two.dropped, 2);
  const Passed past = passed({1000, 1000.1, 0, 1000.3});
  expect_near(past.stamps, {1000, 1000.1, 1000.3});
}

TEST(StampFilter, AClockSetForwardIsTaken) { expect_near(passed({1, 1.1, 101.2, 101.3, 101.4}).stamps, {1, 1.1, 101.2, 101.3, 101.4}); }

TEST(StampFilter, APauseIsNoJump) {
  expect_near(passed({1, 1.1, 31.1, 31.2}, StampFilter::Backward::restamps, {0, 0.1, 30.1, 30.2}).stamps, {1, 1.1, 31.1, 31.2});
}

TEST(StampFilter, AClockSetBackGoesOn) {
  expect_near(passed({101, 101.1, 1.2, 1.3, 1.4}).stamps, {101, 101.1, 101.2, 101.3, 101.4});
  expect_near(passed({101, 101.1, 1.2, 1.3}, StampFilter::Backward::passes).stamps, {101, 101.1, 1.2, 1.3});
}

}  // namespace
}  // namespace sgraph
