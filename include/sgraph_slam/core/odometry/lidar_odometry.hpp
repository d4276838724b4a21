#pragma once

#include <optional>
#include <vector>

#include "sgraph_slam/core/odometry/acceptance.hpp"
#include "sgraph_slam/core/odometry/map_updater.hpp"
#include "sgraph_slam/core/odometry/motion_sensors.hpp"
#include "sgraph_slam/core/odometry/motion_source.hpp"
#include "sgraph_slam/core/odometry/ride_detector.hpp"
#include "sgraph_slam/core/odometry/ride_height.hpp"
#include "sgraph_slam/core/odometry/scan_window.hpp"

namespace sgraph {

/// VGICP against a local map with the motion within the scan solved together with the pose, in a window of two scans (design: odometry study). A
/// scan's live pose comes with it, its final one with the scan after; only final scans enter the map.
class LidarOdometry : public MotionSource {
 public:
  LidarOdometry(const OdometryParams& params, const Pose& T_base_lidar);

  void add(const OdometrySample& sample) override { sensors_.add(sample); }
  void add(const ImuSample& sample) override {
    sensors_.add(sample);
    ride_height_.add(sample);
  }
  void observe_residuals(ResidualSink sink) override { residual_sink_ = std::move(sink); }
  void remember_scans(bool remember) override { local_.remember_scans(remember); }
  void correct(const RingCalibration& added) override;
  MotionOutput process(const CloudPtr& scan) override;
  std::vector<FinalScan> finish() override;

 private:
  enum class Model { window, scan, velocity, none };  // see MotionParams::model

  [[nodiscard]] std::optional<ScanVerdict> refused(const Cloud& cloud) const;
  [[nodiscard]] WindowScan prepare(const CloudPtr& cloud) const;
  void take_out_motion(WindowScan& scan) const;
  void start(WindowScan scan);
  void find_first_motion(const WindowScan& second);
  [[nodiscard]] Pose predicted(double time, bool gap) const;
  [[nodiscard]] std::vector<SegmentMeasurement> measurements() const;
  [[nodiscard]] MeasuredMotion level_motion(const Knot& begin, const Knot& end) const;
  void loosen_prior(WindowProblem& problem) const;
  WindowResult solve(const RigidAlignmentResult& alignment);
  void keep_prediction(const Knots& predicted, const AcceptanceVerdict& verdict, WindowScan& scan);
  void estimate_covariance(const WindowResult& solved, const std::vector<Vector6>& free_directions);
  [[nodiscard]] OdometryEstimate live_estimate(const WindowScan& scan, const WindowResult& solved) const;
  void make_final(std::size_t kept, std::vector<FinalScan>& finals);
  FinalScan make_oldest_final();
  [[nodiscard]] std::optional<Rise> ridden(RideDetector::Seen seen) const;
  [[nodiscard]] Pose pose_between_middles(const WindowScan& scan) const;
  [[nodiscard]] std::vector<SurfaceResidual> residuals(const WindowScan& scan) const;
  void insert_now(const WindowScan& scan);
  [[nodiscard]] Stamp stamp_at(double time) const { return origin_->after(time); }

  OdometryParams params_;
  Model model_;
  bool distributions_;  // see MotionParams::residual
  Pose T_base_lidar_;
  Pose T_lidar_base_;
  MotionSensors sensors_;
  MapUpdater local_;
  ScanWindow window_;
  RideDetector ride_;
  RideHeight ride_height_;
  Acceptance acceptance_;
  std::optional<Stamp> origin_;  // zero of the knots' time
  Stamp last_stamp_;
  double last_end_ = 0;        // of the scan before the newest
  bool motion_known_ = false;  // the motion during the first scan has been found
  ResidualSink residual_sink_;
  std::optional<Knot> last_accepted_;  // at the stamp of the last final scan, if it was accepted
};

}  // namespace sgraph
