#include "sgraph_slam/core/math/walk_cells.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace sgraph {
namespace {

constexpr std::ptrdiff_t row = 100;
constexpr std::ptrdiff_t layer = 100 * row;

std::ptrdiff_t index_of(const Eigen::Vector3d& p) {
  const auto cell = p.array().floor().cast<std::ptrdiff_t>().eval();
  return cell.x() + cell.y() * row + cell.z() * layer;
}

// The cells of a way and their stretches, against points along it.
TEST(WalkCells, VisitsWhatTheWayPassesInOrder) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> at(1, 30);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d from(at(random), at(random), at(random));
    Eigen::Vector3d to(at(random), at(random), at(random));
    if (trial % 4 == 0) to[trial % 3] = from[trial % 3];  // level along an axis
    struct Visit {
      std::ptrdiff_t index;
      std::int64_t begin, end;
    };
    std::vector<Visit> visits;
    walk_cells<3>(from, to, {1, row, layer}, [&](std::ptrdiff_t index, std::int64_t begin, std::int64_t end) {
      visits.push_back({index, begin, end});
      return true;
    });
    ASSERT_FALSE(visits.empty());
    EXPECT_EQ(visits.front().index, index_of(from));
    EXPECT_EQ(visits.front().begin, 0);
    EXPECT_EQ(visits.back().index, index_of(to));
    EXPECT_EQ(visits.back().end, whole_way);
    for (std::size_t i = 0; i < visits.size(); ++i) {
      if (i > 0) {
        EXPECT_EQ(visits[i].begin, visits[i - 1].end);
      }
      const double middle = 0.5 * static_cast<double>(visits[i].begin + visits[i].end) / static_cast<double>(whole_way);
      if (visits[i].end - visits[i].begin > 16) {
        EXPECT_EQ(visits[i].index, index_of(from + middle * (to - from)));
      }
    }
  }
}

TEST(WalkCells, StaysWhereTheWayIsNothingAndStopsWhenToldTo) {
  int visits = 0;
  walk_cells<2>({3.5, 2.5}, {3.5, 2.5}, {1, row}, [&](std::ptrdiff_t index, std::int64_t, std::int64_t end) {
    ++visits;
    EXPECT_EQ(index, 3 + 2 * row);
    EXPECT_EQ(end, whole_way);
    return true;
  });
  EXPECT_EQ(visits, 1);
  walk_cells<2>({9.5, 2.5}, {0.5, 2.5}, {1, row}, [&](std::ptrdiff_t, std::int64_t, std::int64_t) { return ++visits < 4; });
  EXPECT_EQ(visits, 4);
}

// Against a cell at a time: the same cells in the same order, and how many changes each has behind it.
TEST(WalkStretches, VisitsTheCellsThatWalkCellsVisits) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> at(1, 40);
  std::uniform_int_distribution<std::int64_t> change(-whole_way, 3 * whole_way);
  for (int trial = 0; trial < 2000; ++trial) {
    const Eigen::Vector2d from(at(random), at(random));
    Eigen::Vector2d to(at(random), at(random));
    if (trial % 8 == 0) to[trial % 2] = from[trial % 2];  // along an axis
    if (trial % 8 == 1) to = from + Eigen::Vector2d(0.3, -0.2);
    std::array<std::int64_t, 3> changes{change(random), change(random), change(random)};
    std::sort(changes.begin(), changes.end());
    using Visits = std::vector<std::pair<std::ptrdiff_t, std::size_t>>;
    Visits expected;
    walk_cells<2>(from, to, {1, row}, [&](std::ptrdiff_t index, std::int64_t begin, std::int64_t end) {
      if (end == whole_way) return false;
      const auto passed = std::count_if(changes.begin(), changes.end(), [&](std::int64_t c) { return c <= begin + end; });
      expected.emplace_back(index, static_cast<std::size_t>(passed));
      return true;
    });
    Visits found;
    walk_stretches(from, to, {1, row}, changes, [&](std::ptrdiff_t index, std::size_t passed) {
      if (found.empty() || found.back().first != index) found.emplace_back(index, passed);
      EXPECT_EQ(found.back().second, passed);
    });
    ASSERT_EQ(found, expected) << "trial " << trial;
  }
}

}  // namespace
}  // namespace sgraph
