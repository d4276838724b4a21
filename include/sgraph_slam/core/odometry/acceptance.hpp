#pragma once

#include <optional>

#include "sgraph_slam/core/odometry/start_search.hpp"
#include "sgraph_slam/core/odometry/window_solver.hpp"

namespace sgraph {

/// What becomes of a scan that has been registered.
struct AcceptanceVerdict {
  bool accepted = true;
  bool stand_still = false;  ///< not accepted: the prediction isn't to be believed either, the sensor stays where it was
  bool enters_map = true;
};

/// Decides whether a scan's registration is believed, from what the scans before it were like.
class Acceptance {
 public:
  Acceptance(double min_inliers, const RobotParams& robot) : min_inliers_(min_inliers), robot_(robot) {}

  /// The first scan is accepted as it is.
  void start(const Knot& end) { known_ = end; }

  /// A result that the points don't support or contradict, or that no robot can have done, is a jump: not accepted. `end`: where it puts the LiDAR at
  /// the scan's end; `last_end`: of the scan before.
  AcceptanceVerdict accept_or_reject(const WindowResult& solved, const RigidAlignmentResult& alignment, const Knot& end, double last_end,
                                     const Eigen::Vector3d& up);

  /// The LiDAR at the end of the last accepted scan, for one that ends at `time`.
  [[nodiscard]] LastKnown last_known(double time, const Eigen::Vector3d& up) const { return {known_, time, up}; }
  /// The motion between the ends of the last two accepted scans as a velocity (rotation, translation; LiDAR frame, a second); none when they are not
  /// the newest.
  [[nodiscard]] std::optional<Vector6> velocity() const;
  [[nodiscard]] const RobotParams& robot() const { return robot_; }
  /// Scans in a row that were not accepted.
  [[nodiscard]] int rejected() const { return rejected_; }
  /// Share of the keypoints that match, over the last accepted scans; 0 before the first.
  [[nodiscard]] double usual_share() const { return usual_share_; }

 private:
  double min_inliers_;
  RobotParams robot_;
  int rejected_ = 0;
  Knot known_;                  // at the end of the last accepted scan,
  std::optional<Knot> before_;  // and of the one before
  double usual_share_ = 0;
};

}  // namespace sgraph
