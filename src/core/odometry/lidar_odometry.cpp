#include "sgraph_slam/core/odometry/lidar_odometry.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/odometry/thinning.hpp"
#include "sgraph_slam/core/registration/ring_image.hpp"
#include "sgraph_slam/core/registration/vertical.hpp"

namespace sgraph {
namespace {

constexpr double no_times = 1e-3;         // clouds whose points span less [s] have one pose
constexpr double default_step = 0.05;     // [s] between knots before any motion is known
constexpr double least_noise = 0.015;     // [m] of a residual: range noise and what the map doesn't know
constexpr int longest_distrust = 20;      // scans after which even what the map doesn't explain goes into it
constexpr double long_gap = 0.3;          // [s] after which a motion predicted from the last one means little
constexpr double poor_share = 0.7;        // of the usual share of matches: below it other starts are tried,
constexpr double poor_after_gap = 0.9;    // and below this one after a gap
constexpr double clearly_better = 1.1;    // support that another start must have
constexpr double far_rotation = 0.1;      // [rad], and
constexpr double far_translation = 0.15;  // [m]: corrections of the prediction that ask for better support
constexpr double own_surface = 0.1;       // [m] of a point from the surface of its own scan that it lies on
constexpr double usual_change = 15.0;     // a correction's ratio to the change of velocity a step that it speaks of
constexpr double far_share = 0.3;         // of the usual share of matches
constexpr int longest_blindness = 5;      // scans without registration over which the motion is believed to go on
constexpr double covariance_scale = 9.0;  // points on one surface share its errors: their residuals are not independent

CloudPtr moved(const Cloud& cloud, const Pose& T) {
  auto result = std::make_shared<Cloud>(cloud);
  const Eigen::Matrix3f rotation = T.matrix().cast<float>();
  for (Point& point : result->points) {
    const Eigen::Vector3f p = rotation * point.position() + T.translation.cast<float>();
    point.x = p.x();
    point.y = p.y();
    point.z = p.z();
  }
  return result;
}

}  // namespace

LidarOdometry::LidarOdometry(const OdometryParams& params, const Pose& T_base_lidar)
    : params_(params), T_base_lidar_(T_base_lidar), T_lidar_base_(T_base_lidar.inverse()), sensors_(T_base_lidar), map_(params.map) {}

void LidarOdometry::add(const OdometrySample& sample) { sensors_.add(sample); }
void LidarOdometry::add(const ImuSample& sample) { sensors_.add(sample); }

double LidarOdometry::noise() const { return std::max(least_noise, map_.noise()); }

LidarOdometry::WindowScan LidarOdometry::prepare(const CloudPtr& cloud) const {
  WindowScan scan;
  scan.time = cloud->stamp - *origin_;
  scan.cloud = cloud;
  if (params_.motion.model == "none" || params_.motion.model == "velocity") {
    const Knots taken_out = params_.motion.model == "none" || knots_.empty() ? Knots{Knot{}} : knots_;
    const TimeSpan firing = firing_times(*cloud);
    const double middle = scan.time + 0.5 * (firing.begin + firing.end);
    scan.middle = Knot{middle, pose_at(taken_out, scan.time).inverse() * pose_at(taken_out, middle)};
    scan.cloud = deskew(*cloud, scan.time, taken_out);  // without times from here on
  }
  const TimeSpan firing = firing_times(*scan.cloud);
  scan.begin = scan.time + firing.begin;
  scan.end = scan.time + firing.end;
  if (scan.end - scan.begin < no_times) scan.begin = scan.end = scan.time;
  scan.keypoints = thinned(scan.cloud->points, params_.motion.keypoint_leaf);
  if (params_.motion.residual == "distribution") {
    scan.own = std::make_shared<SurfaceMap>(params_.map);
    insert(*scan.own, *scan.cloud, {}, Placing::sure);
  }
  return scan;
}

// The pose at a time after the last knot: by the robot's odometry across a gap, by the gyro what the sensor turned, the rest on the last motion.
Pose LidarOdometry::predicted(double time, bool gap) const {
  const Knot& last = knots_.back();
  Pose pose = pose_at(knots_, time);
  if (gap) {
    // What the last scan itself shows of the velocity is too little for so long: that since the scan before is taken.
    pose = last.pose;
    if (untrusted_ == 0 && before_trusted_) {
      const Vector6 motion = se3_log(before_trusted_->pose.inverse() * trusted_.pose) / (trusted_.time - before_trusted_->time);
      pose = levelled(last.pose, last.pose * se3_exp(motion * (time - last.time)), up());
    }
    if (const auto way = sensors_.way(stamp_at(last.time), stamp_at(time))) pose = last.pose * *way;
  }
  if (const auto turn = sensors_.turn(stamp_at(last.time), stamp_at(time))) pose.rotation = (last.pose.rotation * *turn).normalized();
  return pose;
}

// Adds knots up to the scan's end.
void LidarOdometry::extend_knots(const WindowScan& scan) {
  const double length = scan.end - scan.begin;
  const bool gap = scan.begin - knots_.back().time > default_step;
  const auto predict = [&](double time) { knots_.push_back({time, predicted(time, gap)}); };
  if (length <= 0) {
    predict(scan.end);
  } else {
    // A scan that begins where the last one ended shares its knot; after a gap it gets one of its own.
    if (scan.begin - knots_.back().time > 0.3 * length) predict(scan.begin);
    const double begin = knots_.back().time;
    for (int i = 1; i <= params_.motion.segments; ++i) predict(begin + (scan.end - begin) * i / params_.motion.segments);
  }
  prior_.resize(knots_.size(), {params_.motion.rotation_sigma, params_.motion.translation_sigma});
}

// The first scan: standing still until the second tells otherwise.
void LidarOdometry::begin_map(const WindowScan& scan) {
  const double begin = scan.end > scan.begin ? scan.begin : scan.end - default_step;
  knots_ = {{begin - default_step, T_base_lidar_}, {begin, T_base_lidar_}};
  extend_knots(scan);
  first_free_ = static_cast<int>(knots_.size());
}

std::vector<Keypoint> LidarOdometry::keypoints_in_window() const {
  std::vector<Keypoint> all;
  for (const WindowScan& scan : window_) {
    for (const Point& point : scan.keypoints) {
      const SegmentTime at = locate(knots_, scan.time_of(point));
      const Eigen::Vector3d p = point.position().cast<double>();
      const Surface* own = scan.own ? scan.own->match(p, Eigen::Vector3d::Zero(), own_surface) : nullptr;
      all.push_back({p, own != nullptr ? own->normal : Eigen::Vector3d(Eigen::Vector3d::Zero()), at.segment, at.fraction});
    }
  }
  // The solver takes the newest segment from the last one.
  std::stable_sort(all.begin(), all.end(), [](const Keypoint& a, const Keypoint& b) { return a.segment < b.segment; });
  return all;
}

std::vector<Matrix6> LidarOdometry::held_in_window() const {
  std::vector<Matrix6> held(knots_.size() - 1, Matrix6::Identity());
  for (const WindowScan& scan : window_) {
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
      const double middle = 0.5 * (knots_[i].time + knots_[i + 1].time);
      if (scan.begin < scan.end ? scan.begin < middle && middle < scan.end : knots_[i].time < scan.end && scan.end <= knots_[i + 1].time)
        held[i] = scan.held;
    }
  }
  return held;
}

RigidAlignmentResult LidarOdometry::align(const WindowScan& scan) const {
  const std::vector<SegmentMotion> motions = segment_motions(knots_);
  std::vector<SeenPoint> points;
  for (std::size_t i = 0; i < scan.keypoints.size(); i += 2) {
    const Point& point = scan.keypoints[i];
    const SegmentTime at = locate(knots_, scan.time_of(point));
    const SegmentMotion& motion = motions[static_cast<std::size_t>(at.segment)];
    const Eigen::Vector3d sensor = motion.origin(at.fraction);
    points.push_back({motion.rotate(at.fraction, point.position().cast<double>()) + sensor, sensor});
  }
  RigidAlignmentOptions options;
  options.noise = noise();
  options.kernel_begin = untrusted_ > 0 ? 1.0 : 0.5;
  options.kernel_end = std::max(0.1, 4.0 * noise());
  RigidAlignmentResult best = align_rigidly(map_, points, options);
  const bool far_ahead = scan.end - last_end_ > long_gap;
  const bool as_usual = best.inlier_share >= (far_ahead ? poor_after_gap : poor_share) * usual_share_;
  if (as_usual && (usual_share_ > 0 || !far_ahead)) return best;
  // The prediction was far off (a scan after a gap, a jerk): look around for a better start with few of the points, and align all of them from the
  // best.
  std::vector<SeenPoint> few;
  for (std::size_t i = 0; i < points.size(); i += 4) few.push_back(points[i]);
  RigidAlignmentOptions search = options;
  search.reach = Reach::neighbours;
  search.kernel_begin = 1.5;
  search.iterations = 10;
  // Upright by the walls and floors of the scan itself.
  SurfaceMap own(params_.map);
  insert(own, *deskew(*scan.cloud, scan.time, knots_), pose_at(knots_, scan.time), Placing::sure);
  const Eigen::Quaterniond upright = Eigen::Quaterniond::FromTwoVectors(vertical_of(own, up()).value_or(up()), up());
  const LastKnown known = last_known(scan);
  const Pose predicted = pose_at(knots_, scan.end);
  RigidAlignmentResult found;
  for (const Pose& start : other_starts(known, predicted, pose_at(knots_, last_end_), upright)) {
    search.start = start;
    const RigidAlignmentResult other = align_rigidly(map_, few, search);
    if (plausible(known, other, other.correction * predicted) && other.support > found.support) found = other;
  }
  options.start = found.correction;
  found = align_rigidly(map_, points, options);
  if (plausible(known, found, found.correction * predicted) && found.support > clearly_better * best.support) best = found;
  return best;
}

// What other sensors say of the motion along the segments that are being solved.
std::vector<SegmentMeasurement> LidarOdometry::measurements() const {
  std::vector<SegmentMeasurement> all;
  for (int i = first_free_ - 1; i + 1 < static_cast<int>(knots_.size()); ++i) {
    const Knot* knot = &knots_[static_cast<std::size_t>(i)];
    for (const MeasuredMotion& m : sensors_.between(stamp_at(knot->time), stamp_at(knot[1].time))) all.push_back({i, m});
  }
  return all;
}

WindowResult LidarOdometry::solve(const RigidAlignmentResult& alignment) {
  window_.back().held = alignment.held;
  // The newest scan's knots start from the rigid alignment; where it moved far, the velocity has changed that way and the prior must let it.
  const VelocityPrior prior{params_.motion.rotation_sigma, params_.motion.translation_sigma, so3_log(alignment.correction.rotation) / usual_change,
                            alignment.moved / usual_change};
  const double from = moving_known_ ? last_end_ : knots_[static_cast<std::size_t>(first_free_) - 1].time;
  for (std::size_t i = static_cast<std::size_t>(first_free_) - 1; i < knots_.size(); ++i) {
    if (knots_[i].time < from - 1e-9) continue;
    if (knots_[i].time > from + 1e-9 && static_cast<int>(i) >= first_free_) knots_[i].pose = alignment.correction * knots_[i].pose;
    prior_[i] = prior;
  }
  WindowProblem problem{knots_, first_free_, prior_, keypoints_in_window(), held_in_window(), measurements(), up()};
  WindowOptions options;
  options.distributions = params_.motion.residual == "distribution";
  options.iterations = params_.motion.iterations;
  options.noise = noise();
  options.kernel = std::max(params_.motion.kernel, 3.0 * map_.noise());
  WindowResult result = solve_window(map_, problem, options);
  knots_ = problem.knots;
  return result;
}

// The motion during the first scan is unknown when it arrives: take it from the second, mend the map, and look again.
void LidarOdometry::bootstrap(const WindowScan& second) {
  const WindowScan first = window_.front();
  const Pose anchor = pose_at(knots_, first.time);
  for (int round = 0; round < 4; ++round) {
    map_ = SurfaceMap(params_.map);
    insert_now(first);
    window_ = {second};
    const RigidAlignmentResult alignment = align(second);
    solve(alignment);
    // The first scan's knots on the motion found since, through the pose at its stamp.
    const std::size_t n = knots_.size();
    const Knot& before = knots_[static_cast<std::size_t>(first_free_) - 1];
    const Knot& after = knots_[n - 1];
    const double step = after.time - before.time;
    const Vector6 motion = se3_log(before.pose.inverse() * after.pose) / step;
    for (std::size_t i = 0; i < static_cast<std::size_t>(first_free_); ++i) knots_[i].pose = anchor * se3_exp(motion * (knots_[i].time - first.time));
    for (std::size_t i = static_cast<std::size_t>(first_free_); i < n; ++i)
      knots_[i].pose = pose_at(Knots(knots_.begin(), knots_.begin() + static_cast<std::ptrdiff_t>(i)), knots_[i].time);
  }
  map_ = SurfaceMap(params_.map);
  insert_now(first);
  window_ = {first};
  window_.front().enters_map = false;  // it has
  vertical_ = vertical_of(map_, up());
  moving_known_ = true;
}

void LidarOdometry::insert_now(const WindowScan& scan) {
  insert(map_, *deskew(*scan.cloud, scan.time, knots_), pose_at(knots_, scan.time), Placing::unsure);
}

void LidarOdometry::insert(SurfaceMap& map, const Cloud& deskewed, const Pose& T_odom_lidar, Placing placing) const {
  const Eigen::Matrix3d rotation = T_odom_lidar.matrix();
  const RingImage rings(deskewed);
  for (const Point& point : thinned(deskewed.points, params_.map_leaf)) {
    std::optional<Eigen::Vector3f> normal = rings.normal(point);
    if (normal) normal = rotation.cast<float>() * *normal;
    map.insert(rotation * point.position().cast<double>() + T_odom_lidar.translation, T_odom_lidar.translation, normal, placing);
  }
  map.update();
}

// A scan that got one pose shows best where it was at its middle: elsewhere the pose is off by what the motion taken out of it is wrong by. At the stamp
// it is therefore taken from the middles of this scan and the next.
Pose LidarOdometry::pose_between_middles(const WindowScan& scan) const {
  Knots middles;
  for (const WindowScan* s : {&scan, window_.empty() ? nullptr : &window_.front()}) {
    if (s == nullptr || !s->middle) continue;
    middles.push_back({s->middle->time, pose_at(knots_, s->time) * s->middle->pose});
  }
  return middles.size() == 2 ? pose_at(middles, scan.time) : pose_at(knots_, scan.time);
}

// The oldest scan's pose is as good as it will get: it goes into the map.
FinalScan LidarOdometry::leave_window() {
  const WindowScan scan = window_.front();
  window_.erase(window_.begin());
  const Pose T_odom_lidar = pose_at(knots_, scan.time);
  FinalScan final;
  final.stamp = scan.cloud->stamp;
  final.covariance = scan.covariance;
  final.degenerate = scan.degenerate;
  final.explained = scan.explained;
  final.cloud = deskew(*scan.cloud, scan.time, knots_);
  if (scan.enters_map) insert(map_, *final.cloud, T_odom_lidar, scan.after_gap || !scan.explained ? Placing::unsure : Placing::sure);
  const Pose T_odom_stamp = scan.middle ? pose_between_middles(scan) : T_odom_lidar;
  final.T_odom_base = T_odom_stamp * T_lidar_base_;
  if (scan.middle) final.cloud = moved(*final.cloud, T_odom_stamp.inverse() * T_odom_lidar);
  if (!vertical_) vertical_ = vertical_of(map_, up());
  // A gyro is compared with motions between poses that are known, not with predictions.
  if (scan.explained && last_explained_)
    sensors_.learn(stamp_at(last_explained_->time), stamp_at(scan.time), last_explained_->pose.rotation.conjugate() * T_odom_lidar.rotation);
  last_explained_ = scan.explained ? std::optional(Knot{scan.time, T_odom_lidar}) : std::nullopt;
  // Held from now on: the knots up to this scan's end. The one before stays for the prior, and those that a stamp at the begin of the next scan
  // needs.
  std::size_t end = 0;
  while (end < knots_.size() && knots_[end].time <= scan.end + 1e-9) ++end;
  const std::size_t drop = end > 2 ? end - 2 : 0;
  knots_.erase(knots_.begin(), knots_.begin() + static_cast<std::ptrdiff_t>(drop));
  prior_.erase(prior_.begin(), prior_.begin() + static_cast<std::ptrdiff_t>(drop));
  first_free_ = static_cast<int>(end - drop);
  return final;
}

// Makes the oldest scans final until this many are left.
void LidarOdometry::shrink_window(std::size_t kept, std::vector<FinalScan>& finals) {
  while (window_.size() > kept) finals.push_back(leave_window());
}

// A result that the points don't support is a jump: the prediction is kept and the map isn't touched. A scan that ended far from its prediction must
// be supported better than one that is where it was expected (a doorway shows little that is known).
void LidarOdometry::judge(WindowScan& scan, const WindowResult& solved, const RigidAlignmentResult& alignment, const Knots& predicted) {
  const bool far = alignment.rotation > far_rotation || alignment.translation > far_translation;
  const double needed = std::max(params_.motion.min_inliers, far ? far_share * usual_share_ : 0.0);
  if (solved.inlier_share >= needed && plausible(last_known(scan), alignment, pose_at(knots_, scan.end))) {
    before_trusted_ = trusted_;
    trusted_ = {scan.end, pose_at(knots_, scan.end)};
    untrusted_ = 0;
    usual_share_ += (usual_share_ > 0 ? 0.2 : 1.0) * (solved.inlier_share - usual_share_);
    return;
  }
  // A short blindness is bridged by the prediction; a longer one, or one after a gap, must not run away.
  knots_ = predicted;
  const Pose held = pose_at(knots_, last_end_);
  if (untrusted_ >= longest_blindness || scan.end - last_end_ > long_gap) {
    for (Knot& knot : knots_) {
      if (knot.time > last_end_ + 1e-9) knot.pose = held;
    }
  }
  ++untrusted_;
  scan.explained = false;
  scan.enters_map = untrusted_ > longest_distrust;
}

// How well the newest scan's pose is known, and in which directions it isn't.
void LidarOdometry::rate(WindowScan& newest, const WindowResult& solved, const std::vector<Vector6>& free_directions) const {
  const auto size = solved.information.rows();
  if (size < 6) return;
  // The newest knot's covariance, from odom's axes about the sensor into the base's.
  const Eigen::MatrixXd covariance = solved.information.ldlt().solve(Eigen::MatrixXd::Identity(size, size));
  const Pose base = knots_.back().pose * T_lidar_base_;
  const Matrix6 block = covariance_scale * covariance.bottomRightCorner<6, 6>();
  Matrix6 to_base = Matrix6::Zero();
  const Eigen::Matrix3d r = base.matrix().transpose();
  to_base.topLeftCorner<3, 3>() = r;
  to_base.bottomRightCorner<3, 3>() = r;
  to_base.bottomLeftCorner<3, 3>() = -r * skew(base.translation - knots_.back().pose.translation);
  newest.covariance = to_base * block * to_base.transpose();
  for (const Vector6& d : free_directions) newest.degenerate.push_back((to_base * d).normalized());
}

OdometryEstimate LidarOdometry::live_estimate(const WindowScan& scan, const WindowResult& solved) const {
  OdometryEstimate live;
  live.stamp = scan.cloud->stamp;
  live.T_odom_base = pose_at(knots_, scan.time) * T_lidar_base_;
  live.status = untrusted_ == 0 ? OdometryStatus::tracked : OdometryStatus::predicted;
  live.inlier_share = solved.inlier_share;
  live.residual_rms = solved.residual_rms;
  live.keypoints = static_cast<int>(scan.keypoints.size());
  live.iterations = solved.iterations;
  live.covariance = scan.covariance;
  live.degenerate = scan.degenerate;
  const auto i = static_cast<std::size_t>(std::max(0, locate(knots_, scan.time).segment));
  const Pose step = (knots_[i].pose * T_lidar_base_).inverse() * (knots_[i + 1].pose * T_lidar_base_);
  live.twist = se3_log(step) / (knots_[i + 1].time - knots_[i].time);
  return live;
}

MotionOutput LidarOdometry::process(const CloudPtr& cloud) {
  MotionOutput output;
  if (cloud->size() < 50) {
    output.verdict = ScanVerdict::too_few_points;
    return output;
  }
  if (!origin_) {
    origin_ = cloud->stamp;
  } else if (cloud->stamp <= last_stamp_) {
    output.verdict = ScanVerdict::not_later;
    return output;
  }
  last_stamp_ = cloud->stamp;
  WindowScan scan = prepare(cloud);
  WindowResult solved;
  if (knots_.empty()) {
    begin_map(scan);
    window_.push_back(scan);
    insert_now(scan);
    trusted_ = knots_.back();
  } else {
    if (scan.end <= knots_.back().time + no_times) {
      output.verdict = ScanVerdict::not_later;
      return output;
    }
    // Across a gap the motion says nothing of the scan before: it is as good as it will get, and the map is the better for it.
    const bool gap = scan.begin - last_end_ > long_gap;
    scan.after_gap = gap;
    if (gap && moving_known_) shrink_window(0, output.finals);
    extend_knots(scan);
    if (!moving_known_) bootstrap(scan);
    if (gap) shrink_window(0, output.finals);
    const Knots predicted = knots_;
    const RigidAlignmentResult alignment = align(scan);
    window_.push_back(scan);
    solved = solve(alignment);
    WindowScan& newest = window_.back();
    judge(newest, solved, alignment, predicted);
    rate(newest, solved, alignment.free_directions);
    scan = newest;
  }
  output.live = live_estimate(scan, solved);
  if (solved.iterations == 0) output.live.status = OdometryStatus::started;
  output.deskewed = deskew(*scan.cloud, scan.time, knots_);
  last_end_ = scan.end;
  shrink_window(params_.motion.model == "scan" && moving_known_ ? 0 : 1, output.finals);
  return output;
}

std::vector<FinalScan> LidarOdometry::finish() {
  std::vector<FinalScan> finals;
  shrink_window(0, finals);
  return finals;
}

}  // namespace sgraph
