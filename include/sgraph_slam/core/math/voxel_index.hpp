#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

namespace sgraph {

/// Where a point's voxel is in an array: an open-addressing hash from integer voxel coordinates (21 bits each: 2 million voxels along each axis) to
/// indices that count up from 0 in order of first use, so that iteration order never depends on the hash. Each voxel carries a small tag that is
/// found with it, without touching the array.
class VoxelIndex {
 public:
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

  struct Entry {
    std::uint32_t index = none;
    std::uint32_t tag = 0;
  };

  /// Coordinates of a voxel of some edge; those of the voxel of twice the edge that holds it are half of them, rounded down.
  struct Cell {
    std::int32_t x, y, z;
  };

  explicit VoxelIndex(double edge) : inverse_edge_(1.0 / edge), slots_(1024) {}

  /// The point in the grid's axes: those of a cube that stands on a corner, so that no wall, floor or ceiling of a building lies along the voxels'
  /// borders, where its points would be told apart by their noise.
  [[nodiscard]] static Eigen::Vector3d in_grid(const Eigen::Vector3d& p) {
    constexpr double a = 0.70710678, b = 0.40824829, c = 0.57735027;  // 1 / sqrt(2), 1 / sqrt(6), 1 / sqrt(3)
    return {a * p.x() + b * p.y() + c * p.z(), -a * p.x() + b * p.y() + c * p.z(), -2 * b * p.y() + c * p.z()};
  }

  /// Cell of a point in a grid of the edge 1 / `inverse_edge` [m].
  [[nodiscard]] static Cell cell(const Eigen::Vector3d& p, double inverse_edge) {
    const auto floored = [](double value) {
      const auto truncated = static_cast<std::int32_t>(value);
      return truncated - (static_cast<double>(truncated) > value ? 1 : 0);
    };
    const Eigen::Vector3d at = inverse_edge * in_grid(p);
    return {floored(at.x()), floored(at.y()), floored(at.z())};
  }

  /// Key of the cell that is `halvings` times coarser than the one given.
  [[nodiscard]] static std::uint64_t key(const Cell& cell, int halvings) {
    const auto part = [halvings](std::int32_t c) { return static_cast<std::uint64_t>((c >> halvings) + (1 << 20)) & 0x1FFFFF; };
    return part(cell.x) | part(cell.y) << 21 | part(cell.z) << 42;
  }

  [[nodiscard]] std::uint64_t key(const Eigen::Vector3d& p) const { return key(cell(p, inverse_edge_), 0); }

  /// Index of the voxel, or `none`.
  [[nodiscard]] std::uint32_t find(std::uint64_t key) const { return entry(key).index; }

  /// Index, `none` where there is no such voxel, and tag.
  [[nodiscard]] Entry entry(std::uint64_t key) const {
    for (std::size_t i = slot_of(key);; i = (i + 1) & (slots_.size() - 1)) {
      if (slots_[i].entry.index == none || slots_[i].key == key) return slots_[i].entry;
    }
  }

  /// Index of the voxel; a new one gets the next index and the tag 0.
  std::uint32_t find_or_add(std::uint64_t key) {
    if (2 * (size_ + 1) > slots_.size()) grow();
    for (std::size_t i = slot_of(key);; i = (i + 1) & (slots_.size() - 1)) {
      if (slots_[i].entry.index == none) slots_[i] = {key, {static_cast<std::uint32_t>(size_++), 0}};
      if (slots_[i].key == key) return slots_[i].entry.index;
    }
  }

  /// Sets the tag of a voxel that is known.
  void set_tag(std::uint64_t key, std::uint32_t tag) {
    std::size_t i = slot_of(key);
    while (slots_[i].key != key || slots_[i].entry.index == none) i = (i + 1) & (slots_.size() - 1);
    slots_[i].entry.tag = tag;
  }

  [[nodiscard]] std::size_t size() const { return size_; }

  /// Begins to load where a key is kept: who asks for many keys before the first of them is needed waits once for memory, not each time.
  void ask_for(std::uint64_t key) const { __builtin_prefetch(&slots_[slot_of(key)]); }

 private:
  struct Slot {
    std::uint64_t key = 0;
    Entry entry;
  };

  [[nodiscard]] std::size_t slot_of(std::uint64_t key) const {
    key ^= key >> 31;
    key *= 0x9E3779B97F4A7C15ULL;
    return (key ^ key >> 32) & (slots_.size() - 1);
  }

  void grow() {
    std::vector<Slot> old(2 * slots_.size());
    old.swap(slots_);
    for (const Slot& slot : old) {
      if (slot.entry.index == none) continue;
      std::size_t i = slot_of(slot.key);
      while (slots_[i].entry.index != none) i = (i + 1) & (slots_.size() - 1);
      slots_[i] = slot;
    }
  }

  double inverse_edge_;
  std::size_t size_ = 0;
  std::vector<Slot> slots_;
};

}  // namespace sgraph
