#include "sgraph_slam/core/odometry/scan_window.hpp"

#include <algorithm>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

constexpr double standing_step = 0.05;  // [s] between knots before any motion is known
constexpr double own_surface = 0.1;     // [m] of a point from the surface of its own scan that it lies on
constexpr double usual_change = 15.0;   // a correction's ratio to the change of velocity a step that it speaks of
// The same in a narrow place, where the prior would outvote the few points that hold the motion. A constant acceleration a moves the end of a scan of
// T = 0.1 s by a T^2 / 2 and changes the velocity times a step h = 0.05 s by a h^2: 2; the correction is shared out over the steps of two scans.
constexpr double change_where_narrow = 4.0;
constexpr double same_time = 1e-9;  // [s]

Eigen::Vector3d shortened(const Eigen::Vector3d& v, double most) { return v.norm() > most ? Eigen::Vector3d(v * (most / v.norm())) : v; }

}  // namespace

void ScanWindow::start(const Pose& T_odom_lidar, const WindowScan& scan) {
  const double begin = scan.end > scan.begin ? scan.begin : scan.end - standing_step;
  knots_ = {{begin - standing_step, T_odom_lidar}, {begin, T_odom_lidar}};
  extend(scan, [&](double) { return T_odom_lidar; });
  first_free_ = static_cast<int>(knots_.size());
}

void ScanWindow::extend(const WindowScan& scan, const Prediction& predicted) {
  const double length = scan.end - scan.begin;
  const auto lay = [&](double time) { knots_.push_back({time, predicted(time)}); };
  if (length <= 0) {
    lay(scan.end);
  } else {
    // A scan that begins where the last one ended shares its knot; after a gap it gets one of its own.
    if (scan.begin - knots_.back().time > 0.3 * length) lay(scan.begin);
    const double begin = knots_.back().time;
    for (int i = 1; i <= params_.segments; ++i) lay(begin + (scan.end - begin) * i / params_.segments);
  }
  prior_.resize(knots_.size(), prior());
}

void ScanWindow::carry_motion_back(const WindowScan& first, const Pose& anchor) {
  const std::size_t n = knots_.size();
  const auto held = static_cast<std::size_t>(first_free_);
  const Knot& before = knots_[held - 1];
  const Knot& after = knots_[n - 1];
  const double step = after.time - before.time;
  const Vector6 motion = se3_log(before.pose.inverse() * after.pose) / step;
  for (std::size_t i = 0; i < held; ++i) knots_[i].pose = anchor * se3_exp(motion * (knots_[i].time - first.time));
  for (std::size_t i = held; i < n; ++i)
    knots_[i].pose = pose_at(Knots(knots_.begin(), knots_.begin() + static_cast<std::ptrdiff_t>(i)), knots_[i].time);
}

WindowScan ScanWindow::pop() {
  WindowScan scan = std::move(scans_.front());
  scans_.erase(scans_.begin());
  // The knot before its end stays for the prior, and those that a stamp at the begin of the next scan needs.
  std::size_t end = 0;
  while (end < knots_.size() && knots_[end].time <= scan.end + same_time) ++end;
  const std::size_t drop = end > 2 ? end - 2 : 0;
  knots_.erase(knots_.begin(), knots_.begin() + static_cast<std::ptrdiff_t>(drop));
  prior_.erase(prior_.begin(), prior_.begin() + static_cast<std::ptrdiff_t>(drop));
  first_free_ = static_cast<int>(end - drop);
  return scan;
}

void ScanWindow::correct(const RingCalibration& added) {
  for (WindowScan& scan : scans_) {
    scan.cloud = added.corrected(scan.cloud);
    added.correct(scan.keypoints);
  }
}

void ScanWindow::start_from(const RigidAlignmentResult& alignment, double from) {
  scans_.back().observable = alignment.held;
  VelocityPrior widened = prior();
  const bool narrow = scans_.back().narrow && !scans_.back().in_cabin;
  const double change = narrow ? change_where_narrow : usual_change;
  widened.rotated = so3_log(alignment.correction.rotation) / change;
  widened.translated = alignment.moved / change;
  if (narrow) {
    // Half a sweep sees one side only. Where that is a near wall it leaves the end of the scan so free that a wider prior lets the velocity swing
    // from scan to scan, further each time; no robot can.
    constexpr double step2 = VelocityPrior::step * VelocityPrior::step;
    widened.rotated = shortened(widened.rotated, robot_.angular_acceleration * step2);
    widened.translated = shortened(widened.translated, robot_.acceleration * step2);
  }
  for (std::size_t i = static_cast<std::size_t>(first_free_) - 1; i < knots_.size(); ++i) {
    if (knots_[i].time < from - same_time) continue;
    if (knots_[i].time > from + same_time && static_cast<int>(i) >= first_free_) knots_[i].pose = alignment.correction * knots_[i].pose;
    prior_[i] = widened;
  }
}

WindowProblem ScanWindow::problem(const Eigen::Vector3d& up) const {
  WindowProblem problem;
  problem.knots = knots_;
  problem.first_free = first_free_;
  problem.prior = prior_;
  problem.keypoints = keypoints();
  problem.observable = observable();
  problem.up = up;
  return problem;
}

std::vector<Keypoint> ScanWindow::keypoints() const {
  std::vector<Keypoint> all;
  for (const WindowScan& scan : scans_) {
    if (!scan.accepted) continue;  // its motion is what the scans around it make it
    const bool is_newest = &scan == &scans_.back();
    for (const Point& point : scan.keypoints) {
      const SegmentTime at = locate(knots_, scan.time_of(point));
      const Eigen::Vector3d p = point.position().cast<double>();
      const Surface* own = scan.own ? scan.own->match(p, Eigen::Vector3d::Zero(), own_surface) : nullptr;
      all.push_back({p, own != nullptr ? own->normal : Eigen::Vector3d(Eigen::Vector3d::Zero()), at.segment, at.fraction, is_newest});
    }
  }
  return all;
}

std::vector<Matrix6> ScanWindow::observable() const {
  std::vector<Matrix6> all(knots_.size() - 1, Matrix6::Identity());
  for (const WindowScan& scan : scans_) {
    for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
      const double middle = 0.5 * (knots_[i].time + knots_[i + 1].time);
      if (scan.begin < scan.end ? scan.begin < middle && middle < scan.end : knots_[i].time < scan.end && scan.end <= knots_[i + 1].time)
        all[i] = scan.observable;
    }
  }
  return all;
}

}  // namespace sgraph
