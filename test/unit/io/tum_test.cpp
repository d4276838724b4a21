#include "sgraph_slam/core/io/tum.hpp"

#include <gtest/gtest.h>

#include <random>
#include <sstream>

#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph {
namespace {

Trajectory read(const std::string& text) {
  std::istringstream in(text);
  return read_tum(in, "text");
}

TEST(Tum, WrittenPosesComeBack) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  Trajectory written;
  for (int i = 0; i < 200; ++i) {
    Vector6 xi;
    for (int k = 0; k < 6; ++k) xi[k] = 3 * normal(random);
    written.push_back({Stamp{1'700'000'000'000'000'001 + 99'999'999LL * i}, se3_exp(xi)});
  }
  std::ostringstream out;
  write_tum(written, out);
  const Trajectory back = read(out.str());
  ASSERT_EQ(back.size(), written.size());
  for (std::size_t i = 0; i < back.size(); ++i) {
    EXPECT_EQ(back[i].stamp.nanoseconds, written[i].stamp.nanoseconds);
    EXPECT_LT(se3_log(back[i].pose.inverse() * written[i].pose).norm(), 1e-8);
  }
}

TEST(Tum, TakesWhatOtherProgramsWrite) {
  const Trajectory t = read(
      "# stamp x y z qx qy qz qw\n\n1e1 1 2 3 0 0 0 1\r\n\t11 1 2 3 0 0 0 1  # note\n12.5 -1e-3 2 3 0 0 1 0\n0013.0000000012 0 0 0 0 0 0 -0.999");
  ASSERT_EQ(t.size(), 4u);
  EXPECT_EQ(t[0].stamp.nanoseconds, 10'000'000'000);
  EXPECT_EQ(t[2].stamp.nanoseconds, 12'500'000'000);
  EXPECT_DOUBLE_EQ(t[2].pose.translation.x(), -1e-3);
  EXPECT_EQ(t[3].stamp.nanoseconds, 13'000'000'001);
  EXPECT_NEAR(t[3].pose.rotation.norm(), 1, 1e-12);
  EXPECT_TRUE(read("").empty());
}

TEST(Tum, RefusesWhatIsNoPoseAndNamesTheLine) {
  for (const char* bad : {"1 2 3", "1 0 0 0 0 0 0 1 9", "x 0 0 0 0 0 0 1", "1 0 0 nan 0 0 0 1", "1 0 0 inf 0 0 0 1", "1 0 0 0 0 0 0 0",
                          "1 0 0 0 1 1 1 1", "1..5 0 0 0 0 0 0 1", "1,0,0,0,0,0,0,1", "0.5 0 0 0 0 0 0 1\n0.5 0 0 0 0 0 0 1"}) {
    const std::string text = std::string("# head\n0.25 0 0 0 0 0 0 1\n") + bad;
    try {
      read(text);
      ADD_FAILURE() << "taken: " << bad;
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()).rfind("text:", 0), 0u) << error.what();
    }
  }
  EXPECT_THROW(read_tum("/nonexistent/file.tum"), std::runtime_error);
}

}  // namespace
}  // namespace sgraph
