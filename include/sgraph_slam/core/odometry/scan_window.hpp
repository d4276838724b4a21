#pragma once

#include <functional>
#include <vector>

#include "sgraph_slam/core/odometry/motion_sensors.hpp"
#include "sgraph_slam/core/odometry/params.hpp"
#include "sgraph_slam/core/odometry/window_scan.hpp"
#include "sgraph_slam/core/odometry/window_solver.hpp"
#include "sgraph_slam/core/registration/rigid_alignment.hpp"
#include "sgraph_slam/core/sensor/ring_calibration.hpp"

namespace sgraph {

/// The scans whose motion is still being found, and the LiDAR's motion through them: knots in odom, those of scans that have left held at the front.
class ScanWindow {
 public:
  /// The LiDAR's pose in odom at a time of the knots' clock, before it is measured.
  using Prediction = std::function<Pose(double time)>;

  ScanWindow(const MotionParams& params, const RobotParams& robot) : params_(params), robot_(robot) {}

  [[nodiscard]] bool started() const { return !knots_.empty(); }
  /// Lays the first scan's knots, standing still; none of them is free. The scan itself isn't taken.
  void start(const Pose& T_odom_lidar, const WindowScan& scan);
  /// Lays knots up to the scan's end at the predicted poses. The scan itself isn't taken.
  void extend(const WindowScan& scan, const Prediction& predicted);
  /// Puts the first scan's knots on a constant motion through `anchor` at its stamp, as found between the last held knot and the end, and those after
  /// them on its continuation.
  void carry_motion_back(const WindowScan& first, const Pose& anchor);

  void push(WindowScan scan) { scans_.push_back(std::move(scan)); }
  void replace(WindowScan scan) { scans_ = {std::move(scan)}; }
  [[nodiscard]] WindowScan& newest() { return scans_.back(); }
  [[nodiscard]] const WindowScan& newest() const { return scans_.back(); }
  [[nodiscard]] WindowScan& oldest() { return scans_.front(); }
  [[nodiscard]] const WindowScan& oldest() const { return scans_.front(); }
  [[nodiscard]] std::size_t size() const { return scans_.size(); }
  /// Takes the oldest scan out and holds the knots up to its end from now on; those that nobody needs any more go.
  WindowScan pop();

  /// Takes out of the scans what the beams' errors made of them.
  void correct(const RingCalibration& added);

  /// The newest scan's knots (those later than `from`) start from its rigid alignment; the prior gives way by as much as that moved,
  /// in narrow places by no more than what a robot can do.
  void start_from(const RigidAlignmentResult& alignment, double from);
  /// What is to be solved, without other sensors' measurements.
  [[nodiscard]] WindowProblem problem(const Eigen::Vector3d& up) const;
  void set_knots(Knots knots) { knots_ = std::move(knots); }

  [[nodiscard]] const Knots& knots() const { return knots_; }
  [[nodiscard]] int first_free() const { return first_free_; }
  [[nodiscard]] Pose pose(double time) const { return pose_at(knots_, time); }
  [[nodiscard]] double end() const { return knots_.back().time; }
  /// Time of the last knot that is held.
  [[nodiscard]] double held_until() const { return knots_[static_cast<std::size_t>(first_free_) - 1].time; }
  /// The cloud as seen from the LiDAR's pose at its stamp.
  [[nodiscard]] CloudPtr deskewed(const WindowScan& scan) const { return deskew(*scan.cloud, scan.time, knots_); }

 private:
  [[nodiscard]] std::vector<Keypoint> keypoints() const;
  [[nodiscard]] std::vector<Matrix6> observable() const;
  [[nodiscard]] VelocityPrior prior() const { return {params_.rotation_sigma, params_.translation_sigma}; }

  MotionParams params_;
  RobotParams robot_;
  Knots knots_;                       // of the scans in the window, and two before for the prior
  int first_free_ = 1;                // knots before it are held
  std::vector<VelocityPrior> prior_;  // a knot
  std::vector<WindowScan> scans_;     // in order of time; up to two while a scan is processed
};

}  // namespace sgraph
