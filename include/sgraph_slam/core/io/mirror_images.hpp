#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// Rooms that a window shows and that are not there. Glass, above all with a coating that holds back heat, mirrors a LiDAR's light, and the sensor
/// reports what stands before the pane as if it stood behind it. A point is such an image when
///
/// - its ray passes a wall, within the wall's outline, through a hole that isn't a passage: one that doesn't reach the floor, or one in which the
///   wall itself is seen too (a pane returns the rays that strike it head-on);
/// - what is seen through that hole is for the most part what stands before it, mirrored at one plane a few centimetres behind the wall's face, also
///   when floors and whatever else runs across the wall, and so is its own image, are left aside;
/// - nobody has seen anything there but through such holes.
///
/// Most glass shows both: what is there and, to rays that graze it, what it mirrors. Through a hole that doesn't mirror as a whole a point is an
/// image when
///
/// - rays pass the place where it seems to be and end deeper behind the wall;
/// - something was seen at its image before the wall, but no surface that runs across the wall;
/// - the same holds for a good part of all points that rays pass so, and for one depth of the mirror (half that part will do where points on the pane
///   itself were seen at that depth);
/// - nobody has seen anything there but through such holes.
///
/// So a room behind a door stays, also one that looks like the room before the door; and what lies behind a window stays when it isn't a mirror
/// image.
class MirrorImages {
 public:
  /// Reads the keyframes' clouds three times; holds eight bytes a voxel of 0.1 m in which something was seen, 24 a voxel that is seen through
  /// holes only, and at most 20 MB of cells that rays pass, while it is made.
  MirrorImages(const GraphSnapshot& snapshot, const Pose& T_base_lidar);

  /// Whether a point (map frame) of some keyframe's cloud is an image.
  [[nodiscard]] bool operator()(const Eigen::Vector3d& p_map) const;

  /// Holes that mirror as a whole.
  [[nodiscard]] int holes() const { return holes_; }

 private:
  std::vector<std::uint64_t> images_;  // voxels, sorted
  int holes_ = 0;
};

}  // namespace sgraph
