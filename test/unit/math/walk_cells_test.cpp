#include "sgraph_slam/core/math/walk_cells.hpp"

#include <random>
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

}  // namespace
}  // namespace sgraph
