#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <Eigen/Core>

namespace sgraph {

/// The length of a way in fixed point.
constexpr std::int64_t whole_way = std::int64_t{1} << 32;

/// Visits the cells of a grid that a straight way passes, in order, until `visit(index, begin, end)` says no. `begin`, `end`: between which parts of
/// the way the cell lies, of `whole_way`; the last cell ends there. `from`, `to`: in cells, 0 at the lower corner of the cell with index 0. `rows`:
/// by how much the index grows with a step along each axis. Where a way ends within 1e-8 of its length of a cell's border, the cell beyond may be
/// visited.
///
/// A map asks for this hundreds of millions of times, and which axis is next can't be predicted: so there are no branches but that of the end.
template <int N, class Visit>
void walk_cells(const Eigen::Matrix<double, N, 1>& from, const Eigen::Matrix<double, N, 1>& to, const std::array<std::ptrdiff_t, N>& rows,
                Visit visit) {
  static_assert(N == 2 || N == 3);
  constexpr double no_way = 1e-9;      // [cells]
  std::int64_t next[3];                // where along the way the next cell of each axis begins
  std::int64_t delta[3];               // from one to the next
  std::ptrdiff_t jump[3] = {0, 0, 0};  // of the index
  std::ptrdiff_t at = 0;
  next[2] = std::numeric_limits<std::int64_t>::max();
  delta[2] = 0;
  for (int k = 0; k < N; ++k) {
    const double way = to[k] - from[k];
    const double cell = std::floor(from[k]);
    at += static_cast<std::ptrdiff_t>(cell) * rows[static_cast<std::size_t>(k)];
    jump[k] = way < 0 ? -rows[static_cast<std::size_t>(k)] : rows[static_cast<std::size_t>(k)];
    if (std::abs(way) < no_way) {
      next[k] = std::numeric_limits<std::int64_t>::max();
      delta[k] = 0;
      continue;
    }
    const double step = static_cast<double>(whole_way) / std::abs(way);
    delta[k] = static_cast<std::int64_t>(step);
    next[k] = static_cast<std::int64_t>((way < 0 ? from[k] - cell : cell + 1 - from[k]) * step);
  }
  std::int64_t x = next[0], y = next[1], z = next[2];
  std::int64_t begin = 0;
  for (;;) {
    const bool x_first = x < y;
    const std::int64_t of_two = x_first ? x : y;
    const bool z_first = N == 3 && z < of_two;
    const std::int64_t end = z_first ? z : of_two;
    if (!visit(at, begin, end < whole_way ? end : whole_way) || end > whole_way) return;
    const auto if_so = [](bool so, std::int64_t value) { return value & -static_cast<std::int64_t>(so); };
    const bool x_now = x_first && !z_first;
    const bool y_now = !x_first && !z_first;
    x += if_so(x_now, delta[0]);
    y += if_so(y_now, delta[1]);
    z += if_so(z_first, delta[2]);
    at += if_so(x_now, jump[0]) + if_so(y_now, jump[1]) + if_so(z_first, jump[2]);
    begin = end;
  }
}

/// Visits the cells of a plane grid that `walk_cells` visits, but for the last one, for whoever sets bits: `visit(index, passed)`, in order, where a
/// cell may be visited twice in a row. `passed`: how many of `changes` the middle of the cell's part of the way has reached; these ascend, each twice
/// its part of the way. A column or row at a time, along the longer side of the way, which takes half the time of a cell at a time.
template <std::size_t N, class Visit>
void walk_stretches(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const std::array<std::ptrdiff_t, 2>& rows,
                    const std::array<std::int64_t, N>& changes, Visit visit) {
  constexpr double no_way = 1e-9;  // [cells]
  constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max() / 4;
  std::int64_t next[2];   // where along the way the next cell of each axis begins
  std::int64_t delta[2];  // from one to the next
  std::ptrdiff_t jump[2];
  std::ptrdiff_t at = 0;
  for (int k = 0; k < 2; ++k) {
    const double way = to[k] - from[k];
    const double cell = std::floor(from[k]);
    const std::ptrdiff_t row = rows[static_cast<std::size_t>(k)];
    at += static_cast<std::ptrdiff_t>(cell) * row;
    jump[k] = way < 0 ? -row : row;
    const bool stays = std::abs(way) < no_way;
    const double step = stays ? 0 : static_cast<double>(whole_way) / std::abs(way);
    delta[k] = static_cast<std::int64_t>(step);
    next[k] = stays ? never : static_cast<std::int64_t>((way < 0 ? from[k] - cell : cell + 1 - from[k]) * step);
  }
  const int a = std::abs(to[1] - from[1]) > std::abs(to[0] - from[0]) ? 1 : 0;  // the longer axis
  const std::int64_t first = a == 0 ? 1 : 0;                                    // where both change at once y is the first
  const std::int64_t delta_a = delta[a], delta_b = delta[1 - a];
  const std::ptrdiff_t jump_a = jump[a], jump_b = jump[1 - a];
  std::int64_t end = next[a];       // of the column
  std::int64_t turn = next[1 - a];  // to the next row
  std::int64_t begin = 0;
  std::size_t passed = 0;
  for (;;) {
    while (passed < N && changes[passed] <= 2 * begin) ++passed;
    const std::int64_t limit = passed < N && changes[passed] < 2 * whole_way ? (changes[passed] + 1) / 2 : whole_way;
    while (end < limit) {
      const bool turns = turn < end + first;
      const std::ptrdiff_t beside = at + (turns ? jump_b : 0);
      visit(at, passed);
      visit(beside, passed);
      turn += turns ? delta_b : 0;
      at = beside + jump_a;
      begin = end;
      end += delta_a;
    }
    // A column in which something changes, or the last one: a cell at a time.
    const auto visit_until = [&](std::int64_t out) {
      if (out >= whole_way) return false;
      std::size_t here = passed;
      while (here < N && changes[here] <= begin + out) ++here;
      visit(at, here);
      begin = out;
      return true;
    };
    if (turn < end + first) {
      if (!visit_until(turn)) return;
      turn += delta_b;
      at += jump_b;
    }
    if (!visit_until(end)) return;
    at += jump_a;
    end += delta_a;
  }
}

}  // namespace sgraph
