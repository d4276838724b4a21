#include "sgraph_slam/core/util/progress.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sgraph {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TEST(Progress, WithoutATerminalIsALineEveryTenPercent) {
  Progress progress(50, false);
  std::string all;
  for (int done = 1; done <= 50; ++done) all += progress.after(done, 0.1 * done, 0.01 * done);
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 10);
  EXPECT_THAT(all, StartsWith(" 10 %  5/50 scans  10.0 x real time  0 s left\n"));
  EXPECT_THAT(all, HasSubstr("100 %  50/50 scans"));
  EXPECT_EQ(progress.end(), "");
}

TEST(Progress, ShortRecordingsSkipTenths) {
  Progress progress(3, false);
  EXPECT_THAT(progress.after(1, 0.5, 4), StartsWith(" 33 %  1/3 scans  0.1 x real time  8 s left"));
  EXPECT_THAT(progress.after(2, 0.5, 4), StartsWith(" 67 %"));
  EXPECT_THAT(progress.after(3, 0.5, 4), StartsWith("100 %"));
}

TEST(Progress, OnATerminalOneLineIsRewrittenNowAndThen) {
  Progress progress(1000, true);
  EXPECT_EQ(progress.end(), "");
  int printed = 0;
  for (int done = 1; done <= 1000; ++done) {
    const std::string text = progress.after(done, 0.1 * done, 0.01 * done);
    if (text.empty()) continue;
    ++printed;
    EXPECT_EQ(text.front(), '\r');
    EXPECT_EQ(text.find('\n'), std::string::npos);
  }
  EXPECT_NEAR(printed, 100, 10);  // 10 s, ten times a second
  EXPECT_EQ(progress.end(), "\n");
}

TEST(Progress, AnUnknownLengthPrintsNothing) {
  Progress progress(0, false);
  EXPECT_EQ(progress.after(1, 1, 1), "");
}

}  // namespace
}  // namespace sgraph
