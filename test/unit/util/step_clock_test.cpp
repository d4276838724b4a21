#include "sgraph_slam/core/util/step_clock.hpp"

#include <gtest/gtest.h>

namespace sgraph {
namespace {

TEST(StepClock, HasWhatWasBookedSinceItsStart) {
  StepClock clock;
  clock.start();
  clock.book("a");
  clock.book("b");
  clock.book("a");
  ASSERT_EQ(clock.milliseconds().size(), 2U);
  for (const auto& [step, milliseconds] : clock.milliseconds()) EXPECT_GE(milliseconds, 0) << step;
  clock.start();
  EXPECT_TRUE(clock.milliseconds().empty());
}

}  // namespace
}  // namespace sgraph
