#include "sgraph_slam/core/odometry/odometry.hpp"

#include "sgraph_slam/core/odometry/external_odometry.hpp"
#include "sgraph_slam/core/odometry/keyframe_registration.hpp"
#include "sgraph_slam/core/odometry/keyframe_selector.hpp"
#include "sgraph_slam/core/odometry/lidar_odometry.hpp"
#include "sgraph_slam/core/odometry/ring_calibrator.hpp"

namespace sgraph {

const char* to_string(ScanVerdict value) {
  switch (value) {
    case ScanVerdict::accepted: return "accepted";
    case ScanVerdict::too_few_points: return "too few points";
    case ScanVerdict::not_later: return "stamp not after the last one";
    case ScanVerdict::stamp_jumped: return "stamp far ahead of those after it";
    case ScanVerdict::no_odometry: break;
  }
  return "no odometry at that time";
}

namespace {

KeyframeParams keyframe_params(const OdometryParams& params) {
  KeyframeParams keyframe = params.keyframe;
  const bool poor = params.source == "topic" || params.motion.model == "velocity" || params.motion.model == "none";
  if (keyframe.cloud == "auto") keyframe.cloud = poor ? "scan" : "scans";
  return keyframe;
}

// Scale, heading and slips of wheels or legs, which hardly average out.
DriftRate reckoning_drift(const RobotParams& robot) { return {robot.odometry_heading, robot.odometry_turning, robot.odometry_scale}; }

constexpr double far_above = 50;  // [m]: higher than anything that is seen from one floor

// Poses from wheels are off by more than what the beams are.
CalibrationParams calibration_params(const OdometryParams& params) {
  CalibrationParams calibration = params.calibration;
  if (params.source == "topic" && calibration.mode != "off") calibration.mode = "fixed";
  return calibration;
}

}  // namespace

class Odometry::Implementation {
 public:
  Implementation(const OdometryParams& params, const Pose& T_base_lidar)
      : T_base_lidar_(T_base_lidar),
        calibrator_(calibration_params(params)),
        keyframes_(keyframe_params(params), T_base_lidar, params.source == "topic" ? reckoning_drift(params.robot) : map_drift),
        registration_(params.registration, T_base_lidar) {
    if (params.source == "topic") {
      source_ = std::make_unique<ExternalOdometry>(T_base_lidar);
    } else {
      source_ = std::make_unique<LidarOdometry>(params, T_base_lidar);
    }
  }

  MotionSource& source() { return *source_; }
  [[nodiscard]] std::shared_ptr<const RingCalibration> calibration() const { return calibrator_.calibration(); }

  OdometryOutput process(const CloudPtr& scan) {
    calibrator_.recognise(*scan);
    if (const auto added = calibrator_.added()) source_->correct(*added);
    source_->remember_scans(!calibrator_.decided());
    MotionOutput motion = source_->process(calibrator_.taken_out()->corrected(scan));
    OdometryOutput output;
    output.verdict = motion.verdict;
    output.live = motion.live;
    output.deskewed = motion.deskewed;
    for (const FinalScan& final : motion.finals) take(final, output);
    output.calibration = calibration();
    return output;
  }

  OdometryOutput finish() {
    OdometryOutput output;
    for (const FinalScan& final : source_->finish()) take(final, output);
    if (auto keyframe = keyframes_.finish()) give(*std::move(keyframe), output);
    return output;
  }

 private:
  void take(const FinalScan& final, OdometryOutput& output) {
    output.finals.push_back({final.stamp, final.T_odom_base});
    if (final.ride) above_.z() += far_above;
    Pose T_odom_lidar = final.T_odom_base * T_base_lidar_;
    T_odom_lidar.translation += above_;
    if (final.accepted) calibrator_.add(*final.cloud, T_odom_lidar);
    if (auto keyframe = keyframes_.add(final)) give(*std::move(keyframe), output);
  }

  void give(Keyframe keyframe, OdometryOutput& output) {
    keyframe.measured = registration_.measure(keyframe);
    output.keyframes.push_back(std::move(keyframe));
  }

  Pose T_base_lidar_;
  RingCalibrator calibrator_;
  std::unique_ptr<MotionSource> source_;
  KeyframeSelector keyframes_;
  KeyframeRegistration registration_;
  Eigen::Vector3d above_ = Eigen::Vector3d::Zero();  // where the calibrator sees the floor that a lift came to: walls of two floors are not one plane
};

Odometry::Odometry(const OdometryParams& params, const Pose& T_base_lidar)
    : implementation_(std::make_unique<Implementation>(params, T_base_lidar)) {}
Odometry::~Odometry() = default;
Odometry::Odometry(Odometry&&) noexcept = default;
Odometry& Odometry::operator=(Odometry&&) noexcept = default;

void Odometry::add(const OdometrySample& sample) { implementation_->source().add(sample); }
void Odometry::add(const ImuSample& sample) { implementation_->source().add(sample); }
void Odometry::observe_residuals(ResidualSink sink) { implementation_->source().observe_residuals(std::move(sink)); }
OdometryOutput Odometry::process(const CloudPtr& scan) { return implementation_->process(scan); }
OdometryOutput Odometry::finish() { return implementation_->finish(); }
std::shared_ptr<const RingCalibration> Odometry::calibration() const { return implementation_->calibration(); }

}  // namespace sgraph
