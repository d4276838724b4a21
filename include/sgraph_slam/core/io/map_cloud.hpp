#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// Whether a point of some keyframe's cloud (map frame) is left out of the map.
using LeaveOut = std::function<bool(const Eigen::Vector3d& p_map)>;

/// The keyframes' clouds where the graph has them, in the map frame: the mean of the points in each voxel of edge `leaf` [m]; 0: all points. Voxels
/// beside a surface that hold only its outer noise are left out, as are points that are not finite, and those that `left_out` says so of.
/// Times are 0.
Cloud map_cloud(const GraphSnapshot& snapshot, const Pose& T_base_lidar, double leaf, const LeaveOut& left_out = {});

/// The same cloud kept up while the map grows: only keyframes that are new, or have moved by half a leaf, are read.
class LiveMapCloud {
 public:
  /// `leaf` > 0 [m].
  explicit LiveMapCloud(double leaf);
  ~LiveMapCloud();

  /// Brings it up to a state of the map. A state that lacks a keyframe begins another map.
  void update(const GraphSnapshot& snapshot, const Pose& T_base_lidar);

  /// Without stamp and frame.
  [[nodiscard]] Cloud cloud() const;

 private:
  class Implementation;
  double leaf_;
  std::unique_ptr<Implementation> voxels_;
};

/// A cloud as the bytes of a binary PCD file (x y z intensity, float32).
std::string pcd_bytes(const Cloud& cloud);

/// The floor that a keyframe stands on, in the map: the largest upward-facing horizontal plane below the LiDAR that this keyframe saw; else a level
/// plane at the lowest of the cloud's points. Nothing when neither is known.
std::optional<Plane> floor_below(const GraphSnapshot& snapshot, const SceneKeyframe& keyframe, const Pose& T_base_lidar);

}  // namespace sgraph
