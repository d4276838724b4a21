#include "sgraph_slam/core/util/scattered_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace sgraph {
namespace {

TEST(ScatteredOrder, VisitsEveryIndexOnce) {
  for (std::size_t count = 0; count < 300; ++count) {
    std::vector<int> visits(count, 0);
    visit_scattered(count, [&](std::size_t i) { ++visits.at(i); });
    EXPECT_TRUE(std::all_of(visits.begin(), visits.end(), [](int n) { return n == 1; })) << count;
  }
}

TEST(ScatteredOrder, NeighboursAreFarApart) {
  for (const std::size_t count : {100UL, 1023UL, 28800UL}) {
    std::vector<std::size_t> order;
    visit_scattered(count, [&](std::size_t i) { order.push_back(i); });
    for (std::size_t k = 1; k < count; ++k) {
      const std::size_t gap = order[k] > order[k - 1] ? order[k] - order[k - 1] : order[k - 1] - order[k];
      EXPECT_GT(5 * std::min(gap, count - gap), count);
    }
  }
}

}  // namespace
}  // namespace sgraph
