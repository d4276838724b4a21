#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "sgraph_slam/core/odometry/motion.hpp"
#include "sgraph_slam/core/registration/surface_map.hpp"
#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// A scan whose pose isn't final yet. Times are in seconds of the knots' clock.
struct WindowScan {
  CloudPtr cloud;    ///< LiDAR frame, as measured
  double time = 0;   ///< of its stamp
  double begin = 0;  ///< of its first point,
  double end = 0;    ///< and of its last one; both `time` where the cloud has no times
  std::vector<Point> keypoints;
  std::shared_ptr<const SurfaceMap> own;     ///< of the scan alone, LiDAR frame; null when it isn't needed
  bool accepted = true;                      ///< false: its pose is only a prediction
  bool enters_map = true;                    ///< when it leaves the window
  bool after_gap = false;                    ///< in time: its start was searched for
  bool narrow = false;                       ///< so few keypoints that all that is seen is near
  bool in_cabin = false;                     ///< near on all sides but at most one, and no floor nearby is seen: walls alone hold it
  Matrix6 covariance = Matrix6::Zero();      ///< of its pose, base frame
  std::vector<Vector6> degenerate;           ///< directions that its points don't hold, base frame
  Matrix6 observable = Matrix6::Identity();  ///< projection of a knot's step onto the directions that its points hold, odom's axes
  std::optional<Knot> middle;  ///< of a scan that gets one pose: its time, and the pose seen from that at the stamp, by the motion taken out

  /// When a point was seen; one moment for all where the cloud has no times.
  [[nodiscard]] double time_of(const Point& point) const { return begin < end ? time + static_cast<double>(point.time) : time; }
};

}  // namespace sgraph
