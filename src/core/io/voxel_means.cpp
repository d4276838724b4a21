#include "voxel_means.hpp"

#include <algorithm>
#include <array>

#include "voxel_key.hpp"

namespace sgraph {
namespace {

// A voxel with a smaller share of the points that a neighbour holds is the outer rim of that neighbour's noise, not a surface of its own.
constexpr double least_share = 0.1;

}  // namespace

void VoxelMeans::ask_for_voxel(std::uint64_t key) const {
  const std::uint32_t at = index_.find(key);
  if (at != VoxelIndex::none) __builtin_prefetch(&voxels_[at]);
}

void VoxelMeans::add(const Eigen::Vector3d& p, const Point& point, int sign) {
  waiting_.push_back({voxel_key(p.array() / leaf_), p, point.intensity, point.ring, sign});
  index_.ask_for(waiting_.back().key);
  if (waiting_.size() == batch) put_in();
}

void VoxelMeans::put_in() {
  for (const Waiting& one : waiting_) ask_for_voxel(one.key);
  for (const Waiting& one : waiting_) {
    const std::uint32_t at = index_.find_or_add(one.key);
    if (at == voxels_.size()) {
      voxels_.emplace_back();
      voxels_.back().key = one.key;
      voxels_.back().ring = one.ring;
    }
    Voxel& voxel = voxels_[at];
    voxel.sum += one.sign * one.p;
    voxel.intensity += one.sign * static_cast<double>(one.intensity);
    voxel.count += one.sign;
  }
  waiting_.clear();
}

std::vector<Point> VoxelMeans::points() {
  put_in();
  // Of the six that share a side: whatever way a surface lies, the noise across it enters through one of them.
  constexpr std::uint64_t x = std::uint64_t{1} << (2 * voxel_key_bits);
  constexpr std::uint64_t y = std::uint64_t{1} << voxel_key_bits;
  constexpr std::array<std::uint64_t, 6> ways{x, 0 - x, y, 0 - y, 1, 0 - std::uint64_t{1}};
  std::vector<Point> result;
  result.reserve(voxels_.size());
  for (std::size_t first = 0; first < voxels_.size(); first += batch / ways.size()) {
    const std::size_t end = std::min(voxels_.size(), first + batch / ways.size());
    for (std::size_t i = first; i < end; ++i) {
      for (const std::uint64_t way : ways) index_.ask_for(voxels_[i].key + way);
    }
    for (std::size_t i = first; i < end; ++i) {
      for (const std::uint64_t way : ways) ask_for_voxel(voxels_[i].key + way);
    }
    for (std::size_t i = first; i < end; ++i) {
      const Voxel& voxel = voxels_[i];
      int fullest = 0;
      for (const std::uint64_t way : ways) {
        const std::uint32_t neighbour = index_.find(voxel.key + way);
        if (neighbour != VoxelIndex::none) fullest = std::max(fullest, voxels_[neighbour].count);
      }
      if (voxel.count <= 0 || voxel.count < least_share * fullest) continue;
      Point point;
      point.ring = voxel.ring;
      point.set_position((voxel.sum / voxel.count).cast<float>());
      point.intensity = static_cast<float>(voxel.intensity / voxel.count);
      result.push_back(point);
    }
  }
  return result;
}

}  // namespace sgraph
