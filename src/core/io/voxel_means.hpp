#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/math/voxel_index.hpp"
#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// The mean of the points in each voxel, in the order in which the voxels were met.
///
/// A map has millions of voxels and each point goes to another one, so the time goes into waiting for memory. Points are put in by the batch: the
/// places of a whole batch are asked for before the first of them is needed.
class VoxelMeans {
 public:
  static constexpr std::size_t batch = 64;

  /// `leaf`: edge of a voxel [m]. Voxels are told apart up to a million leaves from the origin.
  explicit VoxelMeans(double leaf) : leaf_(leaf), index_(leaf) {}

  /// `p`: map frame; its voxel's `ring` is that of the first point. `sign`: 1 to put a point in, -1 to take one out that was put in at the same
  /// place.
  void add(const Eigen::Vector3d& p, const Point& point, int sign = 1);

  /// The voxels that hold something, but for those that are the outer noise of a surface beside them; times are 0.
  [[nodiscard]] std::vector<Point> points();

 private:
  struct Voxel {
    std::uint64_t key = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double intensity = 0;
    int count = 0;
    std::uint16_t ring = 0;
  };
  struct Waiting {
    std::uint64_t key = 0;
    Eigen::Vector3d p;
    float intensity = 0;
    std::uint16_t ring = 0;
    int sign = 1;
  };

  void ask_for_voxel(std::uint64_t key) const;
  void put_in();

  double leaf_;
  VoxelIndex index_;
  std::vector<Voxel> voxels_;
  std::vector<Waiting> waiting_;
};

}  // namespace sgraph
