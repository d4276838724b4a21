#include "sgraph_slam/core/odometry/lidar_odometry.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "sgraph_slam/core/math/noise.hpp"
#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/odometry/relocaliser.hpp"
#include "sgraph_slam/core/odometry/thinning.hpp"

namespace sgraph {
namespace {

constexpr std::size_t fewest_points = 50;
// Where all that is seen is near, as in a stairwell, one point in a voxel is too few: on a landing a VLP-16 sees two dozen points of any floor or
// step.
constexpr std::size_t fewest_keypoints = 1500;
constexpr double no_times = 1e-3;       // clouds whose points span less [s] have one pose
constexpr double broken_motion = 0.05;  // [s] between scans after which what the last one shows of the velocity is too little
constexpr int first_rounds = 4;         // of finding the motion during the first scan

CloudPtr moved(const Cloud& cloud, const Pose& T) {
  auto result = std::make_shared<Cloud>(cloud);
  const Eigen::Matrix3f rotation = T.matrix().cast<float>();
  for (Point& point : result->points) point.set_position(rotation * point.position() + T.translation.cast<float>());
  return result;
}

}  // namespace

LidarOdometry::LidarOdometry(const OdometryParams& params, const Pose& T_base_lidar)
    : params_(params),
      model_(params.motion.model == "window"     ? Model::window
             : params.motion.model == "scan"     ? Model::scan
             : params.motion.model == "velocity" ? Model::velocity
                                                 : Model::none),
      distributions_(params.motion.residual == "distribution"),
      T_base_lidar_(T_base_lidar),
      T_lidar_base_(T_base_lidar.inverse()),
      sensors_(T_base_lidar),
      local_(params),
      window_(params.motion, params.robot),
      acceptance_(params.motion.min_inliers, params.robot) {}

MotionOutput LidarOdometry::process(const CloudPtr& cloud) {
  MotionOutput output;
  if (const auto reason = refused(*cloud)) {
    output.verdict = *reason;
    return output;
  }
  if (!origin_) origin_ = cloud->stamp;
  last_stamp_ = cloud->stamp;
  WindowScan scan = prepare(cloud);
  WindowResult solved;
  if (!window_.started()) {
    start(std::move(scan));
  } else if (scan.end <= window_.end() + no_times) {
    output.verdict = ScanVerdict::not_later;
    return output;
  } else {
    // Across a gap the motion says nothing of the scan before: it is as good as it will get, and the map is the better for it.
    scan.after_gap = scan.begin - last_end_ > long_gap;
    if (scan.after_gap && motion_known_) make_final(0, output.finals);
    const bool broken = scan.begin - window_.end() > broken_motion;
    window_.extend(scan, [&](double time) { return predicted(time, broken); });
    if (!motion_known_) find_first_motion(scan);
    if (scan.after_gap) make_final(0, output.finals);
    const Knots prediction = window_.knots();
    const RigidAlignmentResult alignment = find_start(local_, acceptance_, {scan, prediction, last_end_});
    window_.push(std::move(scan));
    solved = solve(alignment);
    WindowScan& newest = window_.newest();
    const AcceptanceVerdict verdict = acceptance_.accept_or_reject(solved, alignment, {newest.end, window_.pose(newest.end)}, last_end_, local_.up());
    if (verdict.accepted) {
      estimate_covariance(solved, alignment.free_directions);
    } else {
      keep_prediction(prediction, verdict, newest);
    }
  }
  const WindowScan& newest = window_.newest();
  output.live = live_estimate(newest, solved);
  output.deskewed = window_.deskewed(newest);
  last_end_ = newest.end;
  make_final(model_ == Model::scan && motion_known_ ? 0 : 1, output.finals);
  return output;
}

// The scans of the window and the map: new and old ones agree from the next scan on.
void LidarOdometry::correct(const RingCalibration& added) {
  window_.correct(added);
  local_.correct(added);
}

std::vector<FinalScan> LidarOdometry::finish() {
  std::vector<FinalScan> finals;
  make_final(0, finals);
  return finals;
}

std::optional<ScanVerdict> LidarOdometry::refused(const Cloud& cloud) const {
  if (cloud.size() < fewest_points) return ScanVerdict::too_few_points;
  if (origin_ && cloud.stamp <= last_stamp_) return ScanVerdict::not_later;
  return std::nullopt;
}

WindowScan LidarOdometry::prepare(const CloudPtr& cloud) const {
  WindowScan scan;
  scan.time = cloud->stamp - *origin_;
  scan.cloud = cloud;
  if (model_ == Model::velocity || model_ == Model::none) take_out_motion(scan);
  const TimeSpan firing = firing_times(*scan.cloud);
  scan.begin = scan.time + firing.begin;
  scan.end = scan.time + firing.end;
  if (scan.end - scan.begin < no_times) scan.begin = scan.end = scan.time;
  // When a lift's doors open the cabin alone holds the robot, until it is known which floor they open on.
  const CloudPtr held_by = ride_.shut() ? ride_.within_cabin(*scan.cloud, window_.knots().back().pose) : scan.cloud;
  scan.keypoints = thinned(held_by->points, params_.motion.keypoint_leaf);
  scan.narrow = scan.keypoints.size() < fewest_keypoints;
  if (scan.narrow) scan.keypoints = thinned(held_by->points, 0.5 * params_.motion.keypoint_leaf);
  scan.in_cabin = scan.narrow && window_.started() && like_a_cabin(*scan.cloud, window_.knots().back().pose, local_.up());
  if (distributions_) scan.own = std::make_shared<SurfaceMap>(local_.map_of(*scan.cloud, {}));
  return scan;
}

// For comparison: the motion within the scan is that of the last one, or none; the scan has one pose from here on.
void LidarOdometry::take_out_motion(WindowScan& scan) const {
  const Knots taken_out = model_ == Model::none || !window_.started() ? Knots{Knot{}} : window_.knots();
  const TimeSpan firing = firing_times(*scan.cloud);
  const double middle = scan.time + 0.5 * (firing.begin + firing.end);
  scan.middle = Knot{middle, pose_at(taken_out, scan.time).inverse() * pose_at(taken_out, middle)};
  scan.cloud = deskew(*scan.cloud, scan.time, taken_out);
}

// The first scan: standing still until the second tells otherwise.
void LidarOdometry::start(WindowScan scan) {
  window_.start(T_base_lidar_, scan);
  insert_now(scan);
  window_.push(std::move(scan));
  acceptance_.start(window_.knots().back());
}

// The motion during the first scan is unknown when it arrives: take it from the second, mend the map, and look again.
void LidarOdometry::find_first_motion(const WindowScan& second) {
  WindowScan first = window_.oldest();
  const Pose anchor = window_.pose(first.time);
  for (int round = 0; round < first_rounds; ++round) {
    local_.clear();
    insert_now(first);
    window_.replace(second);
    solve(find_start(local_, acceptance_, {second, window_.knots(), last_end_}));
    window_.carry_motion_back(first, anchor);
  }
  local_.clear();
  insert_now(first);
  first.enters_map = false;  // it has
  window_.replace(std::move(first));
  local_.find_vertical();
  motion_known_ = true;
}

// The LiDAR's pose at a time after the last knot: by the robot's odometry where the motion is broken off, by the gyro what the sensor turned, the
// rest on the last motion.
Pose LidarOdometry::predicted(double time, bool broken) const {
  const Knot& last = window_.knots().back();
  Pose pose = window_.pose(time);
  if (broken) {
    pose = last.pose;
    if (const auto velocity = acceptance_.velocity()) pose = levelled(last.pose, last.pose * se3_exp(*velocity * (time - last.time)), local_.up());
    if (const auto motion = sensors_.motion_by_odometry(stamp_at(last.time), stamp_at(time))) pose = last.pose * *motion;
  }
  if (const auto rotation = sensors_.rotation_by_gyro(stamp_at(last.time), stamp_at(time)))
    pose.rotation = (last.pose.rotation * *rotation).normalized();
  return pose;
}

// What other sensors say of the motion along the segments that are being solved.
std::vector<SegmentMeasurement> LidarOdometry::measurements() const {
  const Knots& knots = window_.knots();
  std::vector<SegmentMeasurement> all;
  for (int i = window_.first_free() - 1; i + 1 < static_cast<int>(knots.size()); ++i) {
    const Knot* knot = &knots[static_cast<std::size_t>(i)];
    for (const MeasuredMotion& m : sensors_.between(stamp_at(knot->time), stamp_at(knot[1].time))) all.push_back({i, m});
    if (window_.newest().in_cabin) all.push_back({i, level_motion(*knot, knot[1])});
  }
  return all;
}

// A cabin's floor is level: between two knots height and tilt change by a gait's sway alone, which matters where no floor is seen.
MeasuredMotion LidarOdometry::level_motion(const Knot& begin, const Knot& end) const {
  constexpr double sway = 0.003;    // [rad] and
  constexpr double bounce = 0.004;  // [m] in 50 ms
  const double growth = (end.time - begin.time) / 0.05;
  const Eigen::Vector3d up = begin.pose.rotation.conjugate() * local_.up();
  MeasuredMotion level;
  level.motion = {};
  level.information.setZero();
  level.information.topLeftCorner<3, 3>() = (Eigen::Matrix3d::Identity() - up * up.transpose()) / (sway * sway * growth);
  level.information.bottomRightCorner<3, 3>() = up * up.transpose() / (bounce * bounce * growth);
  return level;
}

// A gyro measures how the rotation changes; the prior, which only guesses that it hardly does, would outvote it where the sensor is tipped at once:
// on the first step of a flight a body pitches by 30 degrees within half a second.
void LidarOdometry::loosen_prior(WindowProblem& problem) const {
  constexpr double looser = 20;
  std::vector<bool> measured(problem.knots.size(), false);
  for (const SegmentMeasurement& m : problem.measurements) {
    const bool turn_only = m.measured.information.bottomRightCorner<3, 3>().isZero();
    if (turn_only) measured[static_cast<std::size_t>(m.segment)] = true;
  }
  for (std::size_t i = 1; i + 1 < problem.knots.size(); ++i) {
    if (measured[i - 1] && measured[i]) problem.prior[i].rotation_sigma *= looser;
  }
}

WindowResult LidarOdometry::solve(const RigidAlignmentResult& alignment) {
  window_.start_from(alignment, motion_known_ ? last_end_ : window_.held_until());
  WindowProblem problem = window_.problem(local_.up());
  problem.measurements = measurements();
  loosen_prior(problem);
  WindowOptions options;
  options.distributions = distributions_;
  options.iterations = params_.motion.iterations;
  options.noise = local_.noise();
  // Where all that is seen is near, few points hold the tilt, and it drifts with what the walls in the map lean by; the building's vertical doesn't.
  options.plumb = window_.newest().in_cabin || (window_.newest().narrow && local_.vertical_known());
  options.oblique = !window_.newest().in_cabin;
  options.patch_effect = patch_effect(points_on_patch((window_.newest().narrow ? 0.5 : 1.0) * params_.motion.keypoint_leaf));
  options.kernel = std::max(params_.motion.kernel, 3.0 * local_.map().noise());
  WindowResult result = solve_window(local_.map(), problem, options);
  window_.set_knots(std::move(problem.knots));
  return result;
}

// The scan's own result isn't believed: it stays on the prediction, or where the sensor was.
void LidarOdometry::keep_prediction(const Knots& predicted, const AcceptanceVerdict& verdict, WindowScan& scan) {
  Knots kept = predicted;
  const Pose held = pose_at(kept, last_end_);
  for (Knot& knot : kept) {
    if (verdict.stand_still && knot.time > last_end_ + 1e-9) knot.pose = held;
  }
  window_.set_knots(std::move(kept));
  scan.accepted = false;
  scan.enters_map = verdict.enters_map;
  // Nothing holds it but what a robot can do in the time.
  const double time = scan.end - acceptance_.last_known(scan.end, local_.up()).knot.time;
  scan.covariance.setZero();
  scan.covariance.diagonal().head<3>().setConstant(std::pow(0.5 * params_.robot.angular_acceleration * time * time, 2));
  scan.covariance.diagonal().tail<3>().setConstant(std::pow(0.5 * params_.robot.acceleration * time * time, 2));
  for (int i = 0; i < 6; ++i) scan.degenerate.push_back(Vector6::Unit(i));
}

// How well the scans' poses are known, and in which directions the newest one isn't. The scan before, which the newest one's points have helped to
// place, is the better known.
void LidarOdometry::estimate_covariance(const WindowResult& solved, const std::vector<Vector6>& free_directions) {
  const auto size = solved.information.rows();
  if (size < 6) return;
  const Eigen::MatrixXd covariance = solved.information.ldlt().solve(Eigen::MatrixXd::Identity(size, size));
  const Knots& knots = window_.knots();
  // From odom's axes about the sensor into the base's.
  const auto to_base = [&](const Knot& knot) {
    const Pose base = knot.pose * T_lidar_base_;
    const Eigen::Matrix3d r = base.matrix().transpose();
    Matrix6 turned = Matrix6::Zero();
    turned.topLeftCorner<3, 3>() = r;
    turned.bottomRightCorner<3, 3>() = r;
    turned.bottomLeftCorner<3, 3>() = -r * skew(base.translation - knot.pose.translation);
    return turned;
  };
  const auto estimate = [&](WindowScan& scan) {
    auto i = static_cast<int>(knots.size()) - 1;
    while (i > window_.first_free() && knots[static_cast<std::size_t>(i)].time > scan.end + 1e-9) --i;
    const Matrix6 turned = to_base(knots[static_cast<std::size_t>(i)]);
    const Eigen::Index at = 6 * (i - window_.first_free());
    scan.covariance = turned * covariance.block<6, 6>(at, at) * turned.transpose();
  };
  estimate(window_.newest());
  if (window_.size() > 1 && window_.oldest().accepted && window_.held_until() < window_.oldest().end) estimate(window_.oldest());
  const Matrix6 turned = to_base(knots.back());
  const Eigen::Vector3d up = local_.up();
  for (const Vector6& d : free_directions) {
    // Height and tilt in a cabin are held by its floor, seen or not (`level_motion`).
    const double on_floor = std::hypot(up.dot(d.head<3>()), (d.tail<3>() - up.dot(d.tail<3>()) * up).norm());
    if (window_.newest().in_cabin && on_floor < M_SQRT1_2 * d.norm()) continue;
    window_.newest().degenerate.push_back((turned * d).normalized());
  }
}

OdometryEstimate LidarOdometry::live_estimate(const WindowScan& scan, const WindowResult& solved) const {
  OdometryEstimate live;
  live.stamp = scan.cloud->stamp;
  live.T_odom_base = window_.pose(scan.time) * T_lidar_base_;
  live.status = solved.iterations == 0 ? OdometryStatus::started : scan.accepted ? OdometryStatus::tracked : OdometryStatus::predicted;
  live.inlier_share = solved.inlier_share;
  live.residual_rms = solved.residual_rms;
  live.keypoints = static_cast<int>(scan.keypoints.size());
  live.iterations = solved.iterations;
  live.covariance = scan.covariance;
  live.degenerate = scan.degenerate;
  const Knots& knots = window_.knots();
  const auto i = static_cast<std::size_t>(std::max(0, locate(knots, scan.time).segment));
  const Pose step = (knots[i].pose * T_lidar_base_).inverse() * (knots[i + 1].pose * T_lidar_base_);
  live.twist = se3_log(step) / (knots[i + 1].time - knots[i].time);
  return live;
}

// Makes the oldest scans final until this many are left.
void LidarOdometry::make_final(std::size_t kept, std::vector<FinalScan>& finals) {
  while (window_.size() > kept) finals.push_back(make_oldest_final());
}

// The oldest scan's pose is as good as it will get: it goes into the map.
FinalScan LidarOdometry::make_oldest_final() {
  const WindowScan& oldest = window_.oldest();
  const Pose T_odom_lidar = window_.pose(oldest.time);
  const Pose T_odom_stamp = oldest.middle ? pose_between_middles(oldest) : T_odom_lidar;
  FinalScan final;
  final.cloud = window_.deskewed(oldest);
  if (residual_sink_ && oldest.accepted) residual_sink_(oldest.cloud->stamp, residuals(oldest));
  const WindowScan scan = window_.pop();
  final.stamp = scan.cloud->stamp;
  final.covariance = scan.covariance;
  final.degenerate = scan.degenerate;
  final.accepted = scan.accepted;
  if (scan.accepted) final.ride = ridden(ride_.see(*final.cloud, T_odom_lidar, local_.up()));
  if (!ride_.inside()) ride_height_.forget_before(final.stamp);
  if (final.ride) local_.clear();  // nothing that was seen on the floor before helps on this one
  if (ride_.shut()) final.cloud = ride_.within_cabin(*final.cloud, T_odom_lidar);
  if (scan.enters_map) local_.insert(*final.cloud, T_odom_lidar, scan.after_gap || !scan.accepted ? Placing::unsure : Placing::sure);
  final.T_odom_base = T_odom_stamp * T_lidar_base_;
  if (scan.middle) final.cloud = moved(*final.cloud, T_odom_stamp.inverse() * T_odom_lidar);
  local_.find_vertical();
  // A gyro is compared with motions between poses that are known, not with predictions.
  if (scan.accepted && last_accepted_)
    sensors_.learn(stamp_at(last_accepted_->time), stamp_at(scan.time), last_accepted_->pose.rotation.conjugate() * T_odom_lidar.rotation);
  sensors_.learn_motion(final.stamp, T_odom_lidar, scan.accepted && scan.degenerate.empty());
  last_accepted_ = scan.accepted ? std::optional(Knot{scan.time, T_odom_lidar}) : std::nullopt;
  return final;
}

// What the doors show may look like the floor that was left, or not be comparable; an accelerometer knows better. No two floors are nearer than 1 m.
std::optional<Rise> LidarOdometry::ridden(RideDetector::Seen seen) const {
  constexpr double nearest_floor = 1.0;  // [m]
  constexpr double sure = 4;             // standard deviations
  if (seen == RideDetector::Seen::nothing) return std::nullopt;
  const std::optional<Rise> rise = ride_height_.risen();
  if (!rise) return seen == RideDetector::Seen::another_floor ? std::optional(unknown_rise) : std::nullopt;
  const double height = std::abs(rise->height);
  if (height > std::max(nearest_floor, sure * rise->sigma)) return rise;
  if (height + sure * rise->sigma < nearest_floor) return std::nullopt;
  return seen == RideDetector::Seen::another_floor ? rise : std::nullopt;
}

std::vector<SurfaceResidual> LidarOdometry::residuals(const WindowScan& scan) const {
  const double gate = 4.0 * local_.noise();
  std::vector<SurfaceResidual> all;
  for (const Point& point : scan.keypoints) {
    const Pose T_odom_lidar = window_.pose(scan.time_of(point));
    const Eigen::Vector3d in_odom = T_odom_lidar * point.position().cast<double>();
    const Surface* surface = local_.map().match(in_odom, T_odom_lidar.translation, gate);
    if (surface == nullptr) continue;
    SurfaceResidual r;
    r.range = point.position().norm();
    r.direction = point.position() / r.range;
    r.normal = (T_odom_lidar.rotation.conjugate() * surface->normal).cast<float>();
    r.intensity = point.intensity;
    r.ring = point.ring;
    r.residual = static_cast<float>(surface->distance(in_odom));
    r.sigma = static_cast<float>(std::sqrt(surface->variance));
    all.push_back(r);
  }
  return all;
}

// A scan that got one pose shows best where it was at its middle: elsewhere the pose is off by what the motion taken out of it is wrong by. At the
// stamp it is therefore taken from the middles of this scan and the next.
Pose LidarOdometry::pose_between_middles(const WindowScan& scan) const {
  Knots middles;
  for (const WindowScan* s : {&scan, window_.size() > 1 ? &window_.newest() : nullptr}) {
    if (s == nullptr || !s->middle) continue;
    middles.push_back({s->middle->time, window_.pose(s->time) * s->middle->pose});
  }
  return middles.size() == 2 ? pose_at(middles, scan.time) : window_.pose(scan.time);
}

void LidarOdometry::insert_now(const WindowScan& scan) { local_.insert(*window_.deskewed(scan), window_.pose(scan.time), Placing::unsure); }

}  // namespace sgraph
