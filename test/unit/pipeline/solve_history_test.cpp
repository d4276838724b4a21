#include <gtest/gtest.h>

#include "sgraph_slam/core/pipeline/run.hpp"

namespace sgraph {
namespace {

GraphSnapshot solved(std::int64_t version, int keyframes, double milliseconds) {
  GraphSnapshot state;
  state.version = version;
  state.last_solve.keyframes = keyframes;
  state.last_solve.milliseconds = milliseconds;
  return state;
}

TEST(SolveHistory, HasSolvesThatTookEquallyLong) {
  SolveHistory history;
  history.note(solved(1, 5, 2.0));
  history.note(solved(2, 10, 2.0));
  ASSERT_EQ(history.solves().size(), 2U);
  EXPECT_EQ(history.solves()[1].keyframes, 10);
}

TEST(SolveHistory, HasASolveOnceHoweverOftenItsStateIsSeen) {
  SolveHistory history;
  history.note(solved(0, 0, 0));  // before the first solve
  history.note(solved(1, 5, 2.0));
  history.note(solved(1, 5, 2.0));
  history.note(solved(2, 10, 3.0));
  history.note(solved(2, 10, 3.0));
  EXPECT_EQ(history.solves().size(), 2U);
}

}  // namespace
}  // namespace sgraph
