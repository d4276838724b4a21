#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "sgraph_slam/core/odometry/motion.hpp"
#include "sgraph_slam/core/odometry/motion_sensors.hpp"
#include "sgraph_slam/core/odometry/motion_source.hpp"
#include "sgraph_slam/core/odometry/start_search.hpp"
#include "sgraph_slam/core/odometry/window_solver.hpp"
#include "sgraph_slam/core/registration/rigid_alignment.hpp"
#include "sgraph_slam/core/registration/surface_map.hpp"

namespace sgraph {

/// VGICP against a local map with the motion within the scan solved together with the pose, in a window of two scans (design: odometry study). A
/// scan's live pose comes with it, its final one with the scan after; only final scans enter the map.
class LidarOdometry : public MotionSource {
 public:
  LidarOdometry(const OdometryParams& params, const Pose& T_base_lidar);

  void add(const OdometrySample& sample) override;
  void add(const ImuSample& sample) override;
  MotionOutput process(const CloudPtr& scan) override;
  std::vector<FinalScan> finish() override;

 private:
  struct WindowScan {
    CloudPtr cloud;
    double time = 0;   // of its stamp
    double begin = 0;  // of its first and last point
    double end = 0;
    std::vector<Point> keypoints;
    std::shared_ptr<SurfaceMap> own;       // of the scan alone, LiDAR frame; null when it isn't needed
    bool explained = true;                 // by the map: its pose is more than a prediction
    bool enters_map = true;                // when it leaves the window
    bool after_gap = false;                // in time: its start was searched for
    Matrix6 covariance = Matrix6::Zero();  // of its pose, base frame
    std::vector<Vector6> degenerate;
    Matrix6 held = Matrix6::Identity();  // projection of a knot's step onto the directions that its points hold
    std::optional<Knot> middle;          // of a scan that gets one pose: its time, and the pose seen from that at the stamp, by the motion taken out

    // When a point was seen; one moment for all where the cloud has no times.
    [[nodiscard]] double time_of(const Point& point) const { return begin < end ? time + static_cast<double>(point.time) : time; }
  };

  [[nodiscard]] WindowScan prepare(const CloudPtr& cloud) const;
  void extend_knots(const WindowScan& scan);
  [[nodiscard]] Pose predicted(double time, bool gap) const;
  [[nodiscard]] std::vector<SegmentMeasurement> measurements() const;
  void begin_map(const WindowScan& scan);
  void bootstrap(const WindowScan& scan);
  [[nodiscard]] RigidAlignmentResult align(const WindowScan& scan) const;
  [[nodiscard]] LastKnown last_known(const WindowScan& scan) const { return {trusted_, scan.end, up()}; }
  WindowResult solve(const RigidAlignmentResult& alignment);
  [[nodiscard]] std::vector<Keypoint> keypoints_in_window() const;
  [[nodiscard]] std::vector<Matrix6> held_in_window() const;
  void judge(WindowScan& scan, const WindowResult& solved, const RigidAlignmentResult& alignment, const Knots& predicted);
  void rate(WindowScan& newest, const WindowResult& solved, const std::vector<Vector6>& free_directions) const;
  [[nodiscard]] OdometryEstimate live_estimate(const WindowScan& scan, const WindowResult& solved) const;
  FinalScan leave_window();
  [[nodiscard]] Pose pose_between_middles(const WindowScan& scan) const;
  void shrink_window(std::size_t kept, std::vector<FinalScan>& finals);
  void insert(SurfaceMap& map, const Cloud& deskewed, const Pose& T_odom_lidar, Placing placing) const;
  void insert_now(const WindowScan& scan);
  [[nodiscard]] double noise() const;
  [[nodiscard]] Eigen::Vector3d up() const { return vertical_.value_or(Eigen::Vector3d::UnitZ()); }
  [[nodiscard]] Stamp stamp_at(double time) const { return origin_->after(time); }

  OdometryParams params_;
  Pose T_base_lidar_;
  Pose T_lidar_base_;
  MotionSensors sensors_;
  SurfaceMap map_;
  std::optional<Eigen::Vector3d> vertical_;  // in odom, once floors and ceilings have told
  std::optional<Stamp> origin_;              // zero of the knots' time
  Stamp last_stamp_;
  Knots knots_;                         // of the scans in the window, and two before for the prior
  int first_free_ = 1;                  // knots before it are final
  std::vector<VelocityPrior> prior_;    // a knot
  std::vector<WindowScan> window_;      // the scans that are not final: up to two while a scan is processed
  bool moving_known_ = false;           // the motion during the first scan has been found
  int untrusted_ = 0;                   // scans in a row that the map didn't explain
  double last_end_ = 0;                 // of the scan before the newest
  Knot trusted_;                        // at the end of the last scan that the map explained,
  std::optional<Knot> before_trusted_;  // and of the one before
  std::optional<Knot> last_explained_;  // at the stamp of the last final scan, if the map explained it
  double usual_share_ = 0;              // of points that match, over the last scans
};

}  // namespace sgraph
