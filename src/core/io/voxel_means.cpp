#include "voxel_means.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace sgraph {
namespace {

// A voxel with a smaller share of the points that a neighbour holds is the outer rim of that neighbour's noise, not a surface of its own.
constexpr double least_share = 0.1;
constexpr std::size_t smallest_table = 1024;

}  // namespace

std::uint64_t VoxelMeans::key_of(const Eigen::Vector3d& p) const {
  const auto axis = [this](double value) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(value / leaf_)) + (1 << (bits - 1))) & ((1U << bits) - 1);
  };
  return axis(p.x()) << (2 * bits) | axis(p.y()) << bits | axis(p.z());
}

// Keys of neighbours are powers of two apart; the multiplication by the golden ratio (Knuth) scatters them. Its upper half depends on all of the key.
std::size_t VoxelMeans::home_of(std::uint64_t key) const { return (key * 0x9E3779B97F4A7C15U >> 32) & (table_.size() - 1); }

std::uint32_t VoxelMeans::find(std::uint64_t key) const {
  for (std::size_t at = home_of(key);; at = (at + 1) & (table_.size() - 1)) {
    if (table_[at] == none || voxels_[table_[at]].key == key) return table_[at];
  }
}

void VoxelMeans::ask_for(std::uint64_t key) const { __builtin_prefetch(&table_[home_of(key)]); }

void VoxelMeans::ask_for_voxel(std::uint64_t key) const {
  const std::uint32_t first = table_[home_of(key)];
  if (first != none) __builtin_prefetch(&voxels_[first]);
}

void VoxelMeans::make_room() {
  if (2 * (voxels_.size() + batch) <= table_.size()) return;
  table_.assign(std::max(smallest_table, 2 * table_.size()), none);
  for (std::uint32_t i = 0; i < voxels_.size(); ++i) {
    std::size_t at = home_of(voxels_[i].key);
    while (table_[at] != none) at = (at + 1) & (table_.size() - 1);
    table_[at] = i;
  }
}

void VoxelMeans::add(const Eigen::Vector3d& p, const Point& point, int sign) {
  if (waiting_.empty()) {
    make_room();
    waiting_.reserve(batch);
  }
  waiting_.push_back({key_of(p), p, point.intensity, point.ring, sign});
  ask_for(waiting_.back().key);
  if (waiting_.size() == batch) put_in();
}

void VoxelMeans::put_in() {
  for (const Waiting& one : waiting_) ask_for_voxel(one.key);
  for (const Waiting& one : waiting_) {
    std::uint32_t number = find(one.key);
    if (number == none) {
      number = static_cast<std::uint32_t>(voxels_.size());
      std::size_t at = home_of(one.key);
      while (table_[at] != none) at = (at + 1) & (table_.size() - 1);
      table_[at] = number;
      Voxel& voxel = voxels_.emplace_back();
      voxel.key = one.key;
      voxel.ring = one.ring;
    }
    Voxel& voxel = voxels_[number];
    voxel.sum += one.sign * one.p;
    voxel.intensity += one.sign * static_cast<double>(one.intensity);
    voxel.count += one.sign;
  }
  waiting_.clear();
}

std::vector<Point> VoxelMeans::points() {
  put_in();
  // Of the six that share a side: whatever way a surface lies, the noise across it enters through one of them.
  constexpr std::uint64_t x = std::uint64_t{1} << (2 * bits);
  constexpr std::uint64_t y = std::uint64_t{1} << bits;
  constexpr std::array<std::uint64_t, 6> ways{x, 0 - x, y, 0 - y, 1, 0 - std::uint64_t{1}};
  std::vector<Point> result;
  result.reserve(voxels_.size());
  for (std::size_t first = 0; first < voxels_.size(); first += batch / ways.size()) {
    const std::size_t end = std::min(voxels_.size(), first + batch / ways.size());
    for (const auto& ask : {&VoxelMeans::ask_for, &VoxelMeans::ask_for_voxel}) {
      for (std::size_t i = first; i < end; ++i) {
        for (const std::uint64_t way : ways) (this->*ask)(voxels_[i].key + way);
      }
    }
    for (std::size_t i = first; i < end; ++i) {
      const Voxel& voxel = voxels_[i];
      int fullest = 0;
      for (const std::uint64_t way : ways) {
        const std::uint32_t neighbour = find(voxel.key + way);
        if (neighbour != none) fullest = std::max(fullest, voxels_[neighbour].count);
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
