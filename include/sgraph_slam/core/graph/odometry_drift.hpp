#pragma once

#include <map>

#include "sgraph_slam/core/types/ids.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// How uncertain the motion between any two keyframes is by the odometry alone: an upper bound on their relative uncertainty in the graph. One sum a
/// keyframe; covariances of the steps add up once they are moved to the odometry's frame.
class OdometryDrift {
 public:
  /// `covariance`: of the motion since the keyframe added before; rotation, translation; right perturbation. Keyframes come in order.
  void add(KeyframeId id, const Pose& T_odom_base, const Matrix6& covariance);

  /// Covariance of the motion from `from` to the later `to`, right perturbation at `to`. Zero when one is unknown or they are the same.
  [[nodiscard]] Matrix6 between(KeyframeId from, KeyframeId to) const;

  /// Length of the path between the two [m].
  [[nodiscard]] double path(KeyframeId from, KeyframeId to) const;

 private:
  struct Entry {
    Pose T_odom_base;
    Matrix6 sum;      // of the steps' covariances, left perturbation in the odometry's frame
    double path = 0;  // from the first keyframe
  };
  std::map<KeyframeId, Entry> entries_;
};

}  // namespace sgraph
