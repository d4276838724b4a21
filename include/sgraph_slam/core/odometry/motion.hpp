#pragma once

#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// The sensor's pose at one moment. Between knots it turns at a constant rate and moves along a straight line.
struct Knot {
  double time = 0;  ///< seconds since the odometry began
  Pose pose;        ///< of the LiDAR in odom
};

/// Knots in order of time, at least one.
using Knots = std::vector<Knot>;

/// Motion from one knot to the next in the form that moves a point fastest.
class SegmentMotion {
 public:
  SegmentMotion(const Pose& begin, const Pose& end);

  /// Rotates a point of the sensor's frame into odom's axes as at `fraction` (0 begin, 1 end) of the segment.
  [[nodiscard]] Eigen::Vector3d rotate(double fraction, const Eigen::Vector3d& p) const;
  /// Where the sensor is at `fraction`.
  [[nodiscard]] Eigen::Vector3d origin(double fraction) const { return begin_ + fraction * step_; }

 private:
  Eigen::Matrix3d rotation_;        // at the begin
  Eigen::Matrix3d first_, second_;  // rotation_ * W and rotation_ * W^2, W the unit axis' cross-product matrix (Rodrigues)
  double angle_;
  Eigen::Vector3d begin_, step_;
};

/// The motion of each segment; none for a single knot.
std::vector<SegmentMotion> segment_motions(const Knots& knots);

/// Times of a cloud's first and last firing, in seconds from its stamp. The cloud must not be empty.
struct TimeSpan {
  double begin = 0;
  double end = 0;
};
TimeSpan firing_times(const Cloud& cloud);

/// Index of the knot that begins the segment which holds `time` (an end's segment outside), and how far along it `time` is.
struct SegmentTime {
  int segment = 0;
  double fraction = 0;
};
SegmentTime locate(const Knots& knots, double time);

/// Pose at `time`; outside the knots the last segment's motion goes on.
Pose pose_at(const Knots& knots, double time);

/// What goes on of a motion over a longer time, both in odom: the way in the plane and the turn about the vertical `up` (unit). Steps and
/// sways don't.
Pose levelled(const Pose& from, const Pose& to, const Eigen::Vector3d& up);

/// The cloud as seen from the sensor's pose at its stamp. `stamp_time`: the cloud's stamp in the knots' time. Point times become 0.
CloudPtr deskew(const Cloud& cloud, double stamp_time, const Knots& knots);

}  // namespace sgraph
