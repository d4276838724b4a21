#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace sgraph {

/// A set of cells of a window, a bit each: what a raster of a whole building is asked for cell by cell is done for 64 of them at once.
class CellBits {
 public:
  CellBits(int width, int height)
      : width_(width), height_(height), words_((width + 63) / 64), bits_(static_cast<std::size_t>(words_) * static_cast<std::size_t>(height), 0) {}

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] bool at(int x, int y) const { return (row(y)[x / 64] >> (x % 64) & 1) != 0; }

  /// Sets the cells [begin, end) of a row that are asked for.
  template <class Wanted>
  void set_row(int y, int begin, int end, Wanted wanted) {
    std::uint64_t* to = row(y);
    for (int x = begin; x < end; ++x) to[x / 64] |= static_cast<std::uint64_t>(wanted(x) ? 1 : 0) << (x % 64);
  }
  /// Sets the cells [begin, end) of a row.
  void set(int y, int begin, int end);
  void put(int x, int y, bool in) {
    std::uint64_t& word = row(y)[x / 64];
    const std::uint64_t bit = std::uint64_t{1} << (x % 64);
    word = in ? word | bit : word & ~bit;
  }
  /// Takes a cell out; false when it wasn't in.
  bool take(int x, int y) {
    std::uint64_t& word = row(y)[x / 64];
    const std::uint64_t bit = std::uint64_t{1} << (x % 64);
    const bool was = (word & bit) != 0;
    word &= ~bit;
    return was;
  }

  /// A piece of the window, without the cells at its own border.
  [[nodiscard]] CellBits inside(int x, int y, int width, int height) const;
  /// These cells but for those of another set of the same size.
  [[nodiscard]] CellBits without(const CellBits& other) const;
  /// Visits the stretches [begin, end) of a row, in order.
  void visit_runs(int y, const std::function<void(int begin, int end)>& visit) const;
  /// Visits the cells that have one of another set beside, above or below them, row by row.
  void visit_beside(const CellBits& other, const std::function<void(int x, int y)>& visit) const;

 private:
  friend CellBits further_inside(const CellBits& cells, const std::function<bool(float)>& far_enough);

  [[nodiscard]] std::uint64_t* row(int y) { return bits_.data() + static_cast<std::ptrdiff_t>(y) * words_; }
  [[nodiscard]] const std::uint64_t* row(int y) const { return bits_.data() + static_cast<std::ptrdiff_t>(y) * words_; }

  int width_;
  int height_;
  int words_;
  std::vector<std::uint64_t> bits_;
};

/// The cells that are far enough from the nearest cell outside. The distance [cells] is that of OpenCV's distance transform (L2, mask 5: steps of 1,
/// 1.4 and 2.1969), so within 2 % of the true one; `far_enough` holds from some distance on. Cells at the border of the window are outside.
CellBits further_inside(const CellBits& cells, const std::function<bool(float)>& far_enough);

}  // namespace sgraph
