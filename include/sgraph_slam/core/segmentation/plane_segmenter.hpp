#pragma once

#include <vector>

#include "sgraph_slam/core/segmentation/params.hpp"
#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/pose.hpp"
#include "sgraph_slam/core/types/segments.hpp"

namespace sgraph {

/// Where the LiDAR was, in the cloud's frame, at `time` seconds from the cloud's stamp.
struct Viewpoint {
  double time = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

/// The LiDAR's positions while a keyframe's cloud was made, one a scan, at the stamp of each.
std::vector<Viewpoint> viewpoints(const Keyframe& keyframe, const Pose& T_base_lidar);

/// Third stage: finds the planar surfaces in a keyframe's cloud (paper, Plane Extraction). Deterministic: its random numbers depend on the
/// cloud alone. Stateless and safe to call from several threads.
///
/// Sequential RANSAC: hypotheses from small neighbourhoods, the best one by a truncated quadratic score that counts points beside the plane
/// against it; refit on the inliers; split into connected pieces on the plane; pieces that are coplanar within the noise and near each other are one
/// segment. At last each point goes to the nearest plane, points near the edge of two planes go to neither, and all planes are fitted anew.
class PlaneSegmenter {
 public:
  /// Throws std::runtime_error when thresholds or gaps contradict each other.
  explicit PlaneSegmenter(const SegmentationParams& params);

  /// `cloud` is in the LiDAR's frame, with the origin at the sensor. `labels`, when given, gets for each point the index of its segment, or -1.
  /// Normals point to the LiDAR. Segments come in order of their number of points, most first.
  [[nodiscard]] PlaneSegments process(const Cloud& cloud, std::vector<int>* labels = nullptr) const;

  /// The same for a cloud put together from several scans, which the points' times and the viewpoints (in order of time) tell apart: a point belongs
  /// only to a plane whose free side the LiDAR was on when it fired. So the faces of a wall stay apart when the robot went through its door,
  /// and a normal points to where its surface was seen from: `d` is negative where the LiDAR has passed the plane since.
  [[nodiscard]] PlaneSegments process(const Cloud& cloud, const std::vector<Viewpoint>& viewpoints, std::vector<int>* labels = nullptr) const;

 private:
  SegmentationParams params_;
};

}  // namespace sgraph
