#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

namespace sgraph {

/// The set of voxels that hold a point already: open addressing on a 64-bit key. The grid stands on a corner (see Prefilter).
class VoxelSet {
 public:
  static constexpr int bits_per_axis = 21;

  /// Room for `points` insertions. `leaf` > 0 [m].
  VoxelSet(double leaf, std::size_t points) : scale_(static_cast<float>(1.0 / leaf)) {
    std::size_t size = 64;
    while (size < 2 * points) {
      size *= 2;
      --shift_;
    }
    mask_ = size - 1;
    table_.assign(size, empty);
  }

  /// True when the point is the first in its voxel. Coordinates up to 2^20 leaves are told apart.
  bool insert(float x, float y, float z) {
    const std::uint64_t key = key_of(x, y, z);
    std::size_t slot = (key * 0x9E3779B97F4A7C15ULL) >> shift_;
    while (table_[slot] != empty) {
      if (table_[slot] == key) return false;
      slot = (slot + 1) & mask_;
    }
    table_[slot] = key;
    return true;
  }

 private:
  static constexpr std::uint64_t empty = ~std::uint64_t{0};  // keys have 63 bits

  [[nodiscard]] std::uint64_t key_of(float x, float y, float z) const {
    // Columns of the rotation that takes z to (1, 1, 1) / sqrt(3).
    constexpr float a = 0.70710678F, b = 0.40824829F, c = 0.57735027F;
    const float u = scale_ * (a * x + b * y + c * z);
    const float v = scale_ * (-a * x + b * y + c * z);
    const float w = scale_ * (-2 * b * y + c * z);
    return axis(u) << (2 * bits_per_axis) | axis(v) << bits_per_axis | axis(w);
  }

  static std::uint64_t axis(float value) {
    constexpr std::int32_t half = 1 << (bits_per_axis - 1);
    const auto truncated = static_cast<std::int32_t>(value);
    const std::int32_t floored = truncated - (static_cast<float>(truncated) > value ? 1 : 0);
    return static_cast<std::uint32_t>(floored + half) & ((1U << bits_per_axis) - 1);
  }

  float scale_;
  int shift_ = 64 - 6;
  std::size_t mask_ = 0;
  std::vector<std::uint64_t> table_;
};

}  // namespace sgraph
