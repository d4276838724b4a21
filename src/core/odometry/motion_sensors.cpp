#include "sgraph_slam/core/odometry/motion_sensors.hpp"

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

constexpr double history = 5.0;            // [s] of samples kept
constexpr double tolerance = 0.03;         // [s] that samples may end before the moment asked for
constexpr double longest_hole = 0.2;       // [s] between samples
constexpr double gyro_sigma = 0.0005;      // [rad] of a turn, and
constexpr double gyro_scale = 0.01;        // of its size: scale, axes, clock
constexpr double bias_walk = 1e-8;         // [rad^2/s^3]
constexpr double known_turn = 0.001;       // [rad] of a turn that the gyro is compared with
constexpr double most_disagreement = 9.0;  // [standard deviations squared] on the average before the gyro is left out
constexpr double forgetting = 0.02;        // of the average, a comparison
// What a robot's odometry is trusted with: a share of the motion and something for its coarseness. It knows nothing of sway and tilt.
constexpr double way_sigma = 0.005, height_sigma = 0.02;    // [m]
constexpr double heading_sigma = 0.005, tilt_sigma = 0.02;  // [rad]
constexpr double slip = 0.01;                               // share of a motion that systematic errors don't explain
// Stretches over which it is compared with motion known otherwise: long against what that is known to.
constexpr double long_enough = 0.5;          // [m], or
constexpr double turned_enough = 0.5;        // [rad],
constexpr double longest_stretch = 4.0;      // [s] at most
constexpr double known_translation = 0.004;  // [m], and
constexpr double known_rotation = 0.001;     // [rad] to which the other motion is known
constexpr double believable = 16.0;          // squared standard deviations
constexpr double error_walk = 1e-7;          // growth of the errors' variances a stretch: load and tyres change

template <typename Sample>
void append(std::deque<Sample>& samples, const Sample& sample) {
  if (!samples.empty() && sample.stamp <= samples.back().stamp) return;
  samples.push_back(sample);
  while (samples.back().stamp - samples.front().stamp > history) samples.pop_front();
}

template <typename Sample>
bool covers(const std::deque<Sample>& samples, Stamp begin, Stamp end) {
  return samples.size() >= 2 && samples.front().stamp <= begin && end <= samples.back().stamp.after(tolerance);
}

// Index of the sample after which `stamp` lies, such that there is another.
template <typename Sample>
std::size_t index_before(const std::deque<Sample>& samples, Stamp stamp) {
  const auto after = std::upper_bound(samples.begin(), samples.end(), stamp, [](Stamp t, const Sample& s) { return t < s.stamp; });
  return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - samples.begin() - 1, 0, static_cast<std::ptrdiff_t>(samples.size()) - 2));
}

}  // namespace

void MotionSensors::add(const OdometrySample& sample) {
  if (sample.T_odom_base.translation.allFinite() && sample.T_odom_base.rotation.coeffs().allFinite()) append(odometry_, sample);
}

void MotionSensors::add(const ImuSample& sample) {
  if (sample.angular_velocity.allFinite()) append(gyro_, sample);
}

std::optional<Eigen::Quaterniond> MotionSensors::base_rotation_by_gyro(Stamp begin, Stamp end) const {
  if (!covers(gyro_, begin, end)) return std::nullopt;
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  Stamp at = begin;
  for (std::size_t i = index_before(gyro_, begin); at < end; ++i) {
    i = std::min(i, gyro_.size() - 2);
    const ImuSample& before = gyro_[i];
    const ImuSample& after = gyro_[i + 1];
    const double step = after.stamp - before.stamp;
    if (step > longest_hole) return std::nullopt;
    const bool last = i + 2 == gyro_.size();
    const Stamp until = last ? end : std::min(end, after.stamp);
    const double middle = std::clamp(0.5 * ((at - before.stamp) + (until - before.stamp)) / step, 0.0, 1.0);
    const Eigen::Vector3d rate = (1 - middle) * before.angular_velocity + middle * after.angular_velocity - bias_;
    turn = turn * so3_exp(rate * (until - at));
    at = until;
  }
  return turn.normalized();
}

std::optional<Pose> MotionSensors::raw_base_motion(Stamp begin, Stamp end) const {
  if (!covers(odometry_, begin, end)) return std::nullopt;
  for (std::size_t i = index_before(odometry_, begin); i <= index_before(odometry_, end); ++i) {
    if (odometry_[i + 1].stamp - odometry_[i].stamp > longest_hole) return std::nullopt;
  }
  const auto at = [&](Stamp stamp) {
    const std::size_t i = index_before(odometry_, stamp);
    const OdometrySample& a = odometry_[i];
    const OdometrySample& b = odometry_[i + 1];
    return interpolate(a.T_odom_base, b.T_odom_base, (stamp - a.stamp) / (b.stamp - a.stamp));
  };
  return at(begin).inverse() * at(end);
}

std::optional<Pose> MotionSensors::base_motion_by_odometry(Stamp begin, Stamp end) const {
  auto motion = raw_base_motion(begin, end);
  if (!motion) return std::nullopt;
  const double turned = errors_.turn * so3_log(motion->rotation).z() + errors_.bend * motion->translation.x();
  motion->translation *= 1 + errors_.scale;
  motion->rotation = (motion->rotation * so3_exp({0, 0, turned})).normalized();
  return motion;
}

std::optional<Eigen::Quaterniond> MotionSensors::rotation_by_gyro(Stamp begin, Stamp end) const {
  if (disagreement_ > most_disagreement) return std::nullopt;
  const auto rotation = base_rotation_by_gyro(begin, end);
  if (!rotation) return std::nullopt;
  return T_base_lidar_.rotation.conjugate() * *rotation * T_base_lidar_.rotation;
}

std::optional<Pose> MotionSensors::motion_by_odometry(Stamp begin, Stamp end) const {
  const auto way = base_motion_by_odometry(begin, end);
  if (!way) return std::nullopt;
  return of_lidar(*way);
}

std::vector<MeasuredMotion> MotionSensors::between(Stamp begin, Stamp end) const {
  std::vector<MeasuredMotion> measured;
  const double time = end - begin;
  if (const auto turned = rotation_by_gyro(begin, end)) {
    MeasuredMotion m;
    m.motion.rotation = *turned;
    const double sigma = gyro_sigma + gyro_scale * so3_log(*turned).norm();
    m.information.diagonal().head<3>().setConstant(1.0 / (sigma * sigma + bias_variance_ * time * time));
    measured.push_back(m);
  }
  if (const auto way = base_motion_by_odometry(begin, end)) {
    const double length = way->translation.norm();
    const double turned = std::abs(so3_log(way->rotation).z());
    const double heading =
        heading_sigma + std::hypot(slip, std::sqrt(errors_.turn_variance(0, 0))) * turned + std::sqrt(errors_.turn_variance(1, 1)) * length;
    const double along = way_sigma + std::hypot(slip, std::sqrt(errors_.scale_variance)) * length;
    Vector6 sigma;
    sigma << tilt_sigma, tilt_sigma, heading, along, along, height_sigma;
    const Matrix6 to_base = se3_adjoint(T_base_lidar_);
    MeasuredMotion m;
    m.motion = of_lidar(*way);
    m.information = to_base.transpose() * sigma.array().square().inverse().matrix().asDiagonal() * to_base;
    measured.push_back(m);
  }
  return measured;
}

void MotionSensors::learn(Stamp begin, Stamp end, const Eigen::Quaterniond& turn) {
  const double time = end - begin;
  const auto measured = base_rotation_by_gyro(begin, end);
  if (!measured || time <= 0) return;
  const Eigen::Quaterniond known = T_base_lidar_.rotation * turn * T_base_lidar_.rotation.conjugate();
  const Eigen::Vector3d off = so3_log(known.conjugate() * *measured) / time;
  const double sigma = (known_turn + gyro_scale * so3_log(known).norm()) / time;
  disagreement_ += forgetting * (std::min(100.0, off.squaredNorm() / (3 * (sigma * sigma + bias_variance_))) - disagreement_);
  bias_variance_ += bias_walk * time;
  const double gain = bias_variance_ / (bias_variance_ + sigma * sigma);
  // A single wild reading must not move it.
  bias_ += gain * off * std::min(1.0, 0.1 / std::max(1e-9, off.norm()));
  bias_variance_ *= 1 - gain;
}

void MotionSensors::learn_motion(Stamp stamp, const Pose& T_odom_lidar, bool known) {
  if (!known) {
    known_since_.reset();
    return;
  }
  const Pose T_odom_base = T_odom_lidar * T_base_lidar_.inverse();
  if (!known_since_) {
    known_since_ = {stamp, T_odom_base};
    return;
  }
  const Pose motion = known_since_->second.inverse() * T_odom_base;
  const bool enough = motion.translation.norm() > long_enough || so3_log(motion.rotation).norm() > turned_enough;
  if (!enough && stamp - known_since_->first < longest_stretch) return;
  if (const auto said = raw_base_motion(known_since_->first, stamp)) compare(*said, motion);
  known_since_ = {stamp, T_odom_base};
}

// Two small Kalman filters: of the length, and of the turn.
void MotionSensors::compare(const Pose& said, const Pose& known) {
  const double length = said.translation.norm();
  const double turned = so3_log(said.rotation).z();
  const double off_length = known.translation.norm() - (1 + errors_.scale) * length;
  const double length_noise = known_translation * known_translation + std::pow(slip * length, 2);
  errors_.scale_variance += error_walk;
  const double length_variance = length * length * errors_.scale_variance + length_noise;
  if (length > 0.5 * long_enough && off_length * off_length < believable * length_variance) {
    const double gain = errors_.scale_variance * length / length_variance;
    errors_.scale += gain * off_length;
    errors_.scale_variance *= 1 - gain * length;
  }
  const Eigen::Vector2d h(turned, said.translation.x());
  const double off_turn = so3_log(known.rotation).z() - turned - h.dot(Eigen::Vector2d(errors_.turn, errors_.bend));
  errors_.turn_variance.diagonal().array() += error_walk;
  const double turn_variance = h.dot(errors_.turn_variance * h) + known_rotation * known_rotation + std::pow(slip * turned, 2);
  if (off_turn * off_turn < believable * turn_variance) {
    const Eigen::Vector2d gain = errors_.turn_variance * h / turn_variance;
    errors_.turn += gain[0] * off_turn;
    errors_.bend += gain[1] * off_turn;
    errors_.turn_variance = ((Eigen::Matrix2d::Identity() - gain * h.transpose()) * errors_.turn_variance).eval();
  }
}

}  // namespace sgraph
