#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>

namespace sgraph {

/// Where a point's voxel is in an array: an open-addressing hash from integer voxel coordinates (21 bits each: 2 million voxels along each axis) to
/// indices that count up from 0 in order of first use, so that iteration order never depends on the hash.
class VoxelIndex {
 public:
  static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();

  explicit VoxelIndex(double edge) : inverse_edge_(1.0 / edge), slots_(1024) {}

  /// The point in the grid's axes: those of a cube that stands on a corner, so that no wall, floor or ceiling of a building lies along the voxels'
  /// borders, where its points would be told apart by their noise.
  [[nodiscard]] static Eigen::Vector3d in_grid(const Eigen::Vector3d& p) {
    constexpr double a = 0.70710678, b = 0.40824829, c = 0.57735027;  // 1 / sqrt(2), 1 / sqrt(6), 1 / sqrt(3)
    return {a * p.x() + b * p.y() + c * p.z(), -a * p.x() + b * p.y() + c * p.z(), -2 * b * p.y() + c * p.z()};
  }

  [[nodiscard]] std::uint64_t key(const Eigen::Vector3d& p) const {
    const auto part = [](double cell) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(cell)) + (1 << 20)) & 0x1FFFFF; };
    const Eigen::Vector3d cell = inverse_edge_ * in_grid(p);
    return part(cell.x()) | part(cell.y()) << 21 | part(cell.z()) << 42;
  }

  /// Index of the voxel, or `none`.
  [[nodiscard]] std::uint32_t find(std::uint64_t key) const {
    for (std::size_t i = slot_of(key);; i = (i + 1) & (slots_.size() - 1)) {
      if (slots_[i].index == none || slots_[i].key == key) return slots_[i].index;
    }
  }

  /// Index of the voxel; a new one gets the next index.
  std::uint32_t find_or_add(std::uint64_t key) {
    if (2 * (size_ + 1) > slots_.size()) grow();
    for (std::size_t i = slot_of(key);; i = (i + 1) & (slots_.size() - 1)) {
      if (slots_[i].index == none) slots_[i] = {key, static_cast<std::uint32_t>(size_++)};
      if (slots_[i].key == key) return slots_[i].index;
    }
  }

  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t index = none;
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
      if (slot.index == none) continue;
      std::size_t i = slot_of(slot.key);
      while (slots_[i].index != none) i = (i + 1) & (slots_.size() - 1);
      slots_[i] = slot;
    }
  }

  double inverse_edge_;
  std::size_t size_ = 0;
  std::vector<Slot> slots_;
};

}  // namespace sgraph
