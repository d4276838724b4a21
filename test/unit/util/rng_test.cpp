#include "sgraph_slam/core/util/rng.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sgraph {
namespace {

TEST(RandomStream, EqualSeedAndStreamGiveEqualNumbersInAnyOrder) {
  RandomStream a(5, 1);
  const RandomStream b(5, 1);
  const double third = b.normal(2);
  a.next_normal();
  a.next_normal();
  EXPECT_EQ(a.next_normal(), third);
  EXPECT_NE(RandomStream(6, 1).bits(0), b.bits(0));
  EXPECT_NE(RandomStream(5, 2).bits(0), b.bits(0));
  EXPECT_NE(RandomStream(6, 0).bits(0), b.bits(0));  // not merely shifted
}

TEST(RandomStream, MomentsAreThoseOfTheDistributions) {
  const RandomStream stream(1, 2);
  constexpr int n = 200000;
  double uniform = 0;
  double uniform_square = 0;
  double mean = 0;
  double variance = 0;
  double fourth = 0;
  double lagged = 0;
  int beyond_three = 0;
  for (std::uint64_t i = 0; i < n; ++i) {
    const double u = stream.uniform(i);
    ASSERT_GT(u, 0);
    ASSERT_LT(u, 1);
    uniform += u / n;
    uniform_square += u * u / n;
    const double z = stream.normal(i);
    mean += z / n;
    variance += z * z / n;
    fourth += z * z * z * z / n;
    lagged += z * stream.normal(i + 1) / n;
    beyond_three += std::abs(z) > 3 ? 1 : 0;
  }
  EXPECT_NEAR(uniform, 0.5, 0.003);
  EXPECT_NEAR(uniform_square, 1.0 / 3, 0.003);
  EXPECT_NEAR(mean, 0, 0.01);
  EXPECT_NEAR(variance, 1, 0.015);
  EXPECT_NEAR(fourth, 3, 0.1);
  EXPECT_NEAR(lagged, 0, 0.01);
  EXPECT_NEAR(beyond_three / static_cast<double>(n), 0.0027, 0.0005);
}

TEST(RandomStream, StreamsAreNotCorrelated) {
  constexpr int n = 100000;
  const RandomStream a(7, 1);
  for (const std::uint64_t other : {2ULL, 3ULL, 1000ULL}) {
    const RandomStream b(7, other);
    double product = 0;
    for (std::uint64_t i = 0; i < n; ++i) product += a.normal(i) * b.normal(i) / n;
    EXPECT_NEAR(product, 0, 0.015);
  }
}

}  // namespace
}  // namespace sgraph
