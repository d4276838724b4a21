#include "sgraph_slam/core/sim/motion.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "path.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph::sim {

namespace {

constexpr double knot = 0.05;  // spacing of the spline's control points [s]
constexpr double difference_step = 1e-3;

double clamp01(double x) { return std::min(1.0, std::max(0.0, x)); }

// States at even moments 0, knot, 2 knot ... to the end and a little beyond.
using Sample = Eigen::Matrix<double, 6, 1>;

std::vector<Sample> resample(const std::vector<PlanarState>& states) {
  std::vector<Sample> samples;
  const auto count = static_cast<std::size_t>(std::ceil(states.back().time / knot)) + 1;
  std::size_t k = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) * knot;
    while (k + 2 < states.size() && states[k + 1].time < t) ++k;
    const PlanarState& a = states[k];
    const PlanarState& b = states[std::min(k + 1, states.size() - 1)];
    const double f = b.time > a.time ? clamp01((t - a.time) / (b.time - a.time)) : 0.0;
    const Eigen::Vector2d p = a.position + f * (b.position - a.position);
    Sample sample;
    sample << p.x(), p.y(), a.heading + f * (b.heading - a.heading), 0, a.z + f * (b.z - a.z), 0;
    samples.push_back(sample);
  }
  return samples;
}

// How much it walks at each sample: 0 standing, 1 walking or turning; rises and falls over half a second.
void add_activity(std::vector<Sample>& samples) {
  std::vector<double> moving(samples.size(), 0.0);
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const Sample change = (samples[i] - samples[i - 1]) / knot;
    moving[i] = clamp01(change.head<2>().norm() / 0.2 + std::abs(change[2]) / 0.3);
  }
  constexpr int half = 5;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    double sum = 0;
    for (int k = -half; k <= half; ++k) {
      const auto j = static_cast<std::ptrdiff_t>(i) + k;
      if (j >= 0 && j < static_cast<std::ptrdiff_t>(samples.size())) sum += moving[static_cast<std::size_t>(j)];
    }
    samples[i][3] = sum / (2 * half + 1);
  }
}

// Rounds the height of the floor over half a second, as a body does that is longer than a step, and takes the slope from it.
void add_slope(std::vector<Sample>& samples) {
  constexpr int half = 5;
  constexpr double least_way = 0.005;  // of a knot, below which the robot stands [m]
  const auto at = [&samples](std::ptrdiff_t i) -> const Sample& {
    return samples[static_cast<std::size_t>(std::min(std::max<std::ptrdiff_t>(i, 0), static_cast<std::ptrdiff_t>(samples.size()) - 1))];
  };
  if (std::all_of(samples.begin(), samples.end(), [&](const Sample& s) { return s[4] == samples.front()[4]; })) return;
  std::vector<double> heights(samples.size());
  std::vector<double> slopes(samples.size(), 0.0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    double sum = 0;
    for (int k = -half; k <= half; ++k) sum += at(static_cast<std::ptrdiff_t>(i) + k)[4];
    heights[i] = sum / (2 * half + 1);
    const Sample& before = at(static_cast<std::ptrdiff_t>(i) - half);
    const Sample& after = at(static_cast<std::ptrdiff_t>(i) + half);
    const double way = (after - before).head<2>().norm();
    if (way > 2 * half * least_way) {
      slopes[i] = std::atan2(after[4] - before[4], way);
    } else if (i > 0 && after[4] != before[4]) {
      slopes[i] = slopes[i - 1];
    }
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i][4] = heights[i];
    double sum = 0;
    for (int k = -half; k <= half; ++k) {
      const auto j = std::min(std::max<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(i) + k, 0), static_cast<std::ptrdiff_t>(samples.size()) - 1);
      sum += slopes[static_cast<std::size_t>(j)];
    }
    samples[i][5] = sum / (2 * half + 1);
  }
}

// Cubic from b (u = 0) to c (u = 1) with the slopes of the chords a-c and b-d at its ends.
Eigen::Vector3d catmull_rom(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d, double u) {
  return b + 0.5 * u * (c - a + u * (2 * a - 5 * b + 4 * c - d + u * (3 * (b - c) + d - a)));
}

// The speed at which the route takes `duration` seconds. The time is close to linear in the seconds a metre, so the secant between two of them finds
// it in a few steps; falls back on halving.
double speed_for(const Route& route, MotionProfile profile) {
  const auto late = [&](double pace) {
    profile.speed = 1 / pace;
    return drive_route(route, profile).back().time - route.duration;
  };
  double fast = 1 / 5.0;
  double slow = 1 / 0.05;
  double fast_late = late(fast);
  double slow_late = late(slow);
  if (fast_late > 0 || slow_late < 0) {
    std::ostringstream text;
    text << "no speed makes the route last " << route.duration << " s";
    throw WorldError(text.str());
  }
  double pace = slow;
  for (int i = 0; i < 60; ++i) {
    pace = i % 3 == 2 ? 0.5 * (fast + slow) : fast - fast_late * (slow - fast) / (slow_late - fast_late);
    const double pace_late = late(pace);
    if (std::abs(pace_late) < 1e-3) break;
    (pace_late < 0 ? fast : slow) = pace;
    (pace_late < 0 ? fast_late : slow_late) = pace_late;
  }
  return 1 / pace;
}

Route raised(Route route, double height) {
  for (Waypoint& waypoint : route.waypoints) waypoint.z += height;
  return route;
}

}  // namespace

Motion::Motion(const Route& route, const MotionProfile& profile, std::vector<FloorLevel> floors) : profile_(profile), floors_(std::move(floors)) {
  if (route.duration > 0) profile_.speed = speed_for(route, profile);
  const std::vector<PlanarState> states = drive_route(route, profile_);
  duration_ = states.back().time;
  control_ = resample(states);
  add_activity(control_);
  add_slope(control_);
}

Motion::Motion(const Route& route, const MotionProfile& profile, double floor_z)
    : Motion(raised(route, floor_z), profile, std::vector<FloorLevel>{}) {}

Motion::Motion(Trajectory recorded) : recorded_(std::move(recorded)) {
  if (recorded_.size() < 4) throw WorldError("a recorded walk needs at least four poses");
  for (std::size_t i = 1; i < recorded_.size(); ++i) {
    const double gap = recorded_[i].stamp - recorded_[i - 1].stamp;
    if (gap <= 0 || gap > 0.25) throw WorldError("a recorded walk needs poses in order of stamp, at most 0.25 s apart");
  }
  duration_ = recorded_.back().stamp - recorded_.front().stamp;
  profile_.speed = length() / duration_;
}

double Motion::length() const {
  double sum = 0;
  for (std::size_t i = 1; i < recorded_.size(); ++i) sum += (recorded_[i].pose.translation - recorded_[i - 1].pose.translation).head<2>().norm();
  for (std::size_t i = 1; i < control_.size(); ++i) sum += (control_[i] - control_[i - 1]).head<2>().norm();
  return sum;
}

Motion::Sample Motion::spline_at(double time) const {
  const double x = std::min(std::max(time / knot, 0.0), static_cast<double>(control_.size() - 1));
  const auto i = static_cast<std::ptrdiff_t>(x);
  const double u = x - static_cast<double>(i);
  const double v = 1 - u;
  const double weights[4] = {v * v * v / 6, (3 * u * u * u - 6 * u * u + 4) / 6, (3 * v * v * v - 6 * v * v + 4) / 6, u * u * u / 6};
  Sample sum = Sample::Zero();
  for (std::ptrdiff_t k = 0; k < 4; ++k) {
    const std::ptrdiff_t j = std::min(std::max<std::ptrdiff_t>(i + k - 1, 0), static_cast<std::ptrdiff_t>(control_.size()) - 1);
    sum += weights[k] * control_[static_cast<std::size_t>(j)];
  }
  return sum;
}

Pose Motion::recorded_at(double time) const {
  const double within = std::min(std::max(time, 0.0), duration_);
  const Stamp stamp = recorded_.front().stamp.after(within);
  const auto after = std::upper_bound(recorded_.begin() + 1, recorded_.end() - 1, stamp, [](Stamp s, const StampedPose& p) { return s < p.stamp; });
  const auto i = static_cast<std::size_t>(after - recorded_.begin()) - 1;
  const auto pose = [&](std::size_t k) -> const Pose& { return recorded_[std::min(k, recorded_.size() - 1)].pose; };
  const Pose& a = pose(i);
  const Pose& b = pose(i + 1);
  const Pose& before = pose(i == 0 ? 0 : i - 1);
  const Pose& beyond = pose(i + 2);
  const double u = (within - (recorded_[i].stamp - recorded_.front().stamp)) / (recorded_[i + 1].stamp - recorded_[i].stamp);
  const auto turned = [&](const Pose& p) { return so3_log(a.rotation.conjugate() * p.rotation); };
  return {a.rotation * so3_exp(catmull_rom(turned(before), Eigen::Vector3d::Zero(), turned(b), turned(beyond), u)),
          catmull_rom(before.translation, a.translation, b.translation, beyond.translation, u)};
}

Pose Motion::pose_at(double time) const {
  if (!recorded_.empty()) return recorded_at(time);
  const Sample s = spline_at(time);
  const double phase = M_PI * profile_.step_frequency * time;  // roll swings once in two steps
  const double lean_roll = profile_.tilt * 0.7 * (std::sin(2 * M_PI * 0.31 * time) + 0.43 * std::sin(2 * M_PI * 0.83 * time + 1.0));
  const double lean_pitch = profile_.tilt * 0.7 * (std::sin(2 * M_PI * 0.23 * time + 2.0) + 0.43 * std::sin(2 * M_PI * 0.71 * time));
  const double roll = s[3] * (profile_.sway_roll * std::sin(phase) + lean_roll);
  const double pitch = s[3] * (profile_.sway_pitch * std::sin(2 * phase) + lean_pitch) - s[5];
  const double lift = s[3] * profile_.sway_height * std::sin(2 * phase + 0.8);
  double unevenness = 0;  // fades within half a metre of height where the robot leaves a floor
  for (const FloorLevel& floor : floors_) {
    const double share = std::max(0.0, 1 - 2 * std::abs(s[4] - floor.z));
    if (share > 0) unevenness += share * floor.shape(s.head<2>());
  }
  return {Eigen::AngleAxisd(s[2], Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
              Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()),
          Eigen::Vector3d(s[0], s[1], s[4] + unevenness + profile_.base_height + lift)};
}

Vector6 Motion::twist_at(double time) const {
  constexpr double h = difference_step;
  const Pose before = pose_at(time - h);
  const Pose after = pose_at(time + h);
  const Eigen::Quaterniond rotation = pose_at(time).rotation;
  Vector6 twist;
  twist.head<3>() = so3_log(before.rotation.conjugate() * after.rotation) / (2 * h);
  twist.tail<3>() = rotation.conjugate() * ((after.translation - before.translation) / (2 * h));
  return twist;
}

Eigen::Vector3d Motion::acceleration_at(double time) const {
  constexpr double h = difference_step;
  return (pose_at(time - h).translation - 2 * pose_at(time).translation + pose_at(time + h).translation) / (h * h);
}

Motion motion_along_route(const World& world) {
  std::vector<FloorLevel> floors;
  for (const Storey& storey : world.storeys) floors.push_back({storey.elevation, storey.floor_shape});
  return {world.route, world.motion, floors};
}

}  // namespace sgraph::sim
