#include "sgraph_slam/core/places/cell_bits.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <utility>
#include <vector>

namespace sgraph {
namespace {

using Cells = std::vector<std::vector<char>>;  // [y][x]

constexpr int border = 1;  // as of a window: nothing is in there

Cells random_cells(int width, int height, double share, unsigned seed) {
  std::mt19937 rng(seed);
  std::bernoulli_distribution in(share);
  Cells cells(static_cast<std::size_t>(height), std::vector<char>(static_cast<std::size_t>(width), 0));
  for (int y = border; y < height - border; ++y) {
    for (int x = border; x < width - border; ++x) cells[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] = in(rng);
  }
  return cells;
}

CellBits bits_of(const Cells& cells) {
  const int width = static_cast<int>(cells.front().size());
  CellBits bits(width, static_cast<int>(cells.size()));
  for (int y = 0; y < bits.height(); ++y)
    bits.set_row(y, 0, width, [&](int x) { return cells[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] != 0; });
  return bits;
}

// Distance from a cell to the nearest one outside the set, in steps of 1, 1.4 and 2.1969: the shortest way over any of the steps.
double distance(const Cells& cells, int x, int y) {
  double least = 1e9;
  for (int v = 0; v < static_cast<int>(cells.size()); ++v) {
    for (int u = 0; u < static_cast<int>(cells.front().size()); ++u) {
      if (cells[static_cast<std::size_t>(v)][static_cast<std::size_t>(u)]) continue;
      const auto [b, a] = std::minmax({std::abs(u - x), std::abs(v - y)});
      // With n steps of a knight's kind the rest is straight or diagonal.
      for (int n = 0; n <= b; ++n) {
        if (2 * n > a) break;
        const auto [low, high] = std::minmax({a - 2 * n, b - n});
        if (low >= 0) least = std::min(least, 2.1969 * n + 1.4 * low + (high - low));
      }
    }
  }
  return least;
}

TEST(CellBits, AreFurtherInsideWhereTheDistanceSaysSo) {
  int found = 0;
  for (const auto& [share, radius] : {std::pair(0.995, 4.0), std::pair(0.99, 2.7), std::pair(0.998, 6.2), std::pair(0.6, 0.5)}) {
    const Cells cells = random_cells(150, 40, share, 3);
    const CellBits inside = further_inside(bits_of(cells), [radius = radius](float d) { return d > static_cast<float>(radius); });
    for (int y = 0; y < 40; ++y) {
      for (int x = 0; x < 150; ++x) {
        ASSERT_EQ(inside.at(x, y), distance(cells, x, y) > radius + 1e-4) << x << ' ' << y << " radius " << radius;
        found += inside.at(x, y) ? 1 : 0;
      }
    }
  }
  EXPECT_GT(found, 500);
}

TEST(CellBits, HaveTheRunsOfTheirRows) {
  for (const double share : {0.02, 0.5, 0.97}) {
    const Cells cells = random_cells(200, 30, share, 7);
    const CellBits bits = bits_of(cells);
    CellBits again(200, 30);
    for (int y = 0; y < 30; ++y) {
      int last = -1;
      bits.visit_runs(y, [&](int begin, int end) {
        EXPECT_GT(begin, last);
        EXPECT_GT(end, begin);
        last = end;
        again.set(y, begin, end);
      });
      for (int x = 0; x < 200; ++x) ASSERT_EQ(again.at(x, y), cells[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] != 0) << x << ' ' << y;
    }
  }
}

TEST(CellBits, ARunReachesTheEndOfARowOfWholeWords) {
  CellBits bits(128, 1);
  bits.set(0, 3, 128);
  std::vector<std::pair<int, int>> runs;
  bits.visit_runs(0, [&](int begin, int end) { runs.emplace_back(begin, end); });
  EXPECT_EQ(runs, (std::vector<std::pair<int, int>>{{3, 128}}));
}

TEST(CellBits, KnowWhichLieBesideOthers) {
  const Cells a = random_cells(140, 20, 0.5, 1);
  const Cells b = random_cells(140, 20, 0.1, 2);
  std::vector<std::pair<int, int>> expected;
  const auto in = [](const Cells& cells, int x, int y) {
    return x >= 0 && y >= 0 && x < 140 && y < 20 && cells[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] != 0;
  };
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 140; ++x) {
      if (in(a, x, y) && (in(b, x - 1, y) || in(b, x + 1, y) || in(b, x, y - 1) || in(b, x, y + 1))) expected.emplace_back(x, y);
    }
  }
  std::vector<std::pair<int, int>> found;
  bits_of(a).visit_beside(bits_of(b), [&](int x, int y) { found.emplace_back(x, y); });
  EXPECT_EQ(found, expected);
}

TEST(CellBits, GiveACellAwayOnce) {
  CellBits bits(70, 2);
  bits.set(1, 60, 70);
  EXPECT_TRUE(bits.take(64, 1));
  EXPECT_FALSE(bits.take(64, 1));
  EXPECT_FALSE(bits.take(5, 1));
  CellBits others(70, 2);
  others.set(1, 60, 63);
  const CellBits rest = bits.without(others);
  EXPECT_FALSE(rest.at(62, 1));
  EXPECT_TRUE(rest.at(63, 1));
}

TEST(CellBits, HavePiecesWithoutTheirBorders) {
  const Cells cells = random_cells(200, 12, 0.5, 3);
  const CellBits bits = bits_of(cells);
  for (const int first : {0, 5, 63, 64, 70}) {
    for (const int width : {3, 63, 64, 65, 128, 130}) {
      const CellBits piece = bits.inside(first, 2, width, 9);
      for (int y = 0; y < 9; ++y) {
        for (int x = 0; x < (width + 63) / 64 * 64; ++x) {
          const bool inner = x > 0 && y > 0 && x < width - 1 && y < 8;
          ASSERT_EQ(piece.at(x, y), inner && bits.at(first + x, 2 + y)) << x << ' ' << y << " from " << first << " width " << width;
        }
      }
    }
  }
}

}  // namespace
}  // namespace sgraph
