#pragma once

#include <cmath>
#include <cstdint>

#include <Eigen/Core>

namespace sgraph {

constexpr int voxel_key_bits = 21;  // an axis: voxels are told apart up to a million of them from the origin

/// The number of the voxel that holds a point given in voxels; z counts by one, y and x by 2^21 and 2^42.
inline std::uint64_t voxel_key(const Eigen::Array3d& p) {
  constexpr std::uint64_t mask = (std::uint64_t{1} << voxel_key_bits) - 1;
  const auto part = [](double v) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v)) + (1 << (voxel_key_bits - 1))) & mask;
  };
  return part(p.x()) << (2 * voxel_key_bits) | part(p.y()) << voxel_key_bits | part(p.z());
}

}  // namespace sgraph
