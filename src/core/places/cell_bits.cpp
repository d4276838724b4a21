#include "sgraph_slam/core/places/cell_bits.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sgraph {
namespace {

constexpr int fixed_point = 1 << 16;  // distances are sums of steps in these units, as OpenCV's

// A step from a cell to one nearby, and its length.
struct Step {
  int x, y;
  int length;
};

std::vector<Step> steps() {
  const auto unit = [](float length) { return static_cast<int>(std::lround(length * fixed_point)); };
  std::vector<Step> all;
  for (int y = -2; y <= 2; ++y) {
    for (int x = -2; x <= 2; ++x) {
      const int squared = x * x + y * y;
      if (squared == 1) all.push_back({x, y, unit(1.0F)});
      if (squared == 2) all.push_back({x, y, unit(1.4F)});
      if (squared == 5) all.push_back({x, y, unit(2.1969F)});
    }
  }
  return all;
}

// Which cells around one must be in the set too: for each row from `-reach` to `reach` as far as this to both sides, -1 for none.
std::vector<int> widths_of_ball(const std::function<bool(float)>& far_enough) {
  int reach = 0;
  while (!far_enough(static_cast<float>(reach + 1))) ++reach;  // a straight way is the longest for its length
  const int side = 2 * reach + 5;
  const int middle = reach + 2;
  std::vector<int> length(static_cast<std::size_t>(side * side), std::numeric_limits<int>::max() / 2);
  const auto at = [&](int x, int y) -> int& {
    return length[static_cast<std::size_t>(y) * static_cast<std::size_t>(side) + static_cast<std::size_t>(x)];
  };
  at(middle, middle) = 0;
  const std::vector<Step> all = steps();
  for (bool changed = true; changed;) {
    changed = false;
    for (int y = 2; y < side - 2; ++y) {
      for (int x = 2; x < side - 2; ++x) {
        for (const Step& step : all) {
          const int by_step = at(x, y) + step.length;
          if (by_step >= at(x + step.x, y + step.y)) continue;
          at(x + step.x, y + step.y) = by_step;
          changed = true;
        }
      }
    }
  }
  std::vector<int> widths;
  for (int y = -reach; y <= reach; ++y) {
    int width = -1;
    const auto is_near = [&](int x) { return !far_enough(static_cast<float>(at(middle + x, middle + y)) * (1.0F / fixed_point)); };
    while (width < reach && is_near(width + 1)) ++width;
    widths.push_back(width);
  }
  return widths;
}

}  // namespace

void CellBits::set(int y, int begin, int end) {
  std::uint64_t* to = row(y);
  for (int x = begin; x < end;) {
    const int next = std::min(end, x / 64 * 64 + 64);
    const std::uint64_t ones = next - x == 64 ? ~std::uint64_t{0} : ((std::uint64_t{1} << (next - x)) - 1) << (x % 64);
    to[x / 64] |= ones;
    x = next;
  }
}

CellBits CellBits::inside(int x, int y, int width, int height) const {
  CellBits piece(width, height);
  const int shift = x % 64;
  for (int r = 1; r + 1 < height; ++r) {
    const std::uint64_t* from = row(y + r) + x / 64;
    const std::uint64_t* const end = row(y + r) + words_;
    std::uint64_t* to = piece.row(r);
    for (int w = 0; w < piece.words_; ++w) {
      to[w] = from[w] >> shift;
      if (shift > 0 && from + w + 1 < end) to[w] |= from[w + 1] << (64 - shift);
    }
    to[0] &= ~std::uint64_t{1};
    const int last = width - 1;  // what lies beyond it in its word isn't the piece's
    to[last / 64] &= (std::uint64_t{1} << (last % 64)) - 1;
  }
  return piece;
}

CellBits CellBits::without(const CellBits& other) const {
  CellBits rest = *this;
  for (std::size_t i = 0; i < bits_.size(); ++i) rest.bits_[i] &= ~other.bits_[i];
  return rest;
}

void CellBits::visit_runs(int y, const std::function<void(int begin, int end)>& visit) const {
  const std::uint64_t* from = row(y);
  int begin = -1;
  for (int w = 0; w < words_; ++w) {
    for (std::uint64_t changes = from[w] ^ (from[w] << 1 | (begin >= 0 ? 1 : 0)); changes != 0; changes &= changes - 1) {
      const int x = 64 * w + __builtin_ctzll(changes);
      if (begin < 0) {
        begin = x;
        continue;
      }
      visit(begin, x);
      begin = -1;
    }
  }
  if (begin >= 0) visit(begin, width_);
}

void CellBits::visit_beside(const CellBits& other, const std::function<void(int x, int y)>& visit) const {
  for (int y = 0; y < height_; ++y) {
    const std::uint64_t* own = row(y);
    const std::uint64_t* level = other.row(y);
    for (int w = 0; w < words_; ++w) {
      std::uint64_t beside = level[w] << 1 | level[w] >> 1;
      if (w > 0) beside |= level[w - 1] >> 63;
      if (w + 1 < words_) beside |= level[w + 1] << 63;
      if (y > 0) beside |= other.row(y - 1)[w];
      if (y + 1 < height_) beside |= other.row(y + 1)[w];
      for (std::uint64_t found = own[w] & beside; found != 0; found &= found - 1) visit(64 * w + __builtin_ctzll(found), y);
    }
  }
}

CellBits further_inside(const CellBits& cells, const std::function<bool(float)>& far_enough) {
  const std::vector<int> widths = widths_of_ball(far_enough);
  const int reach = static_cast<int>(widths.size()) / 2;
  const int words = cells.words_;
  CellBits inside(cells.width_, cells.height_);
  std::fill(inside.bits_.begin(), inside.bits_.end(), ~std::uint64_t{0});
  // Of a row: cells that are in the set with as many beside them on both sides as the index says.
  std::vector<std::vector<std::uint64_t>> narrowed(static_cast<std::size_t>(reach) + 1, std::vector<std::uint64_t>(static_cast<std::size_t>(words)));
  for (int y = 0; y < cells.height_; ++y) {
    std::copy(cells.row(y), cells.row(y) + words, narrowed[0].begin());
    for (std::size_t k = 1; k < narrowed.size(); ++k) {
      const std::uint64_t* from = narrowed[k - 1].data();
      for (int w = 0; w < words; ++w) {
        const std::uint64_t left = from[w] << 1 | (w > 0 ? from[w - 1] >> 63 : 0);
        const std::uint64_t right = from[w] >> 1 | (w + 1 < words ? from[w + 1] << 63 : 0);
        narrowed[k][static_cast<std::size_t>(w)] = from[w] & left & right;
      }
    }
    for (std::size_t k = 0; k < widths.size(); ++k) {
      const int off = static_cast<int>(k) - reach;
      const int width = widths[k];
      if (width < 0 || y + off < 0 || y + off >= cells.height_) continue;
      std::uint64_t* to = inside.row(y + off);
      const std::vector<std::uint64_t>& own = narrowed[static_cast<std::size_t>(width)];
      for (int w = 0; w < words; ++w) to[w] &= own[static_cast<std::size_t>(w)];
    }
  }
  return inside;
}

}  // namespace sgraph
