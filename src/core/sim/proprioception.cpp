#include "sgraph_slam/core/sim/proprioception.hpp"

#include <cmath>

#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/util/rng.hpp"
#include "streams.hpp"

namespace sgraph::sim {

namespace {

struct PlanarPose {
  Eigen::Vector2d position;
  double heading;
};

PlanarPose planar(const Pose& pose) { return {pose.translation.head<2>(), yaw_of(pose.rotation)}; }

Stamp stamp_at(std::int64_t start, double time) { return {start + std::llround(time * 1e9)}; }

}  // namespace

std::vector<EncoderReading> simulate_encoders(const Motion& motion, double duration, const EncoderSettings& settings, std::uint64_t seed,
                                              std::int64_t start) {
  RandomStream errors(seed, static_cast<std::uint64_t>(Stream::odometry_errors));
  RandomStream noise(seed, static_cast<std::uint64_t>(Stream::odometry_noise));
  const double scale = 1 + settings.scale * errors.next_normal();
  const double heading_scale = 1 + settings.heading_scale * errors.next_normal();
  const double drift = settings.heading_drift * errors.next_normal();
  const double dt = 1 / settings.rate;
  const auto count = static_cast<int>(std::floor(duration / dt));

  std::vector<EncoderReading> readings;
  PlanarPose last = planar(motion.pose_at(0));
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double heading = 0;
  for (int i = 0; i <= count; ++i) {
    const PlanarPose now = planar(motion.pose_at(i * dt));
    double turned = std::remainder(now.heading - last.heading, 2 * M_PI);
    Eigen::Vector2d moved = Eigen::Rotation2Dd(-last.heading - 0.5 * turned) * (now.position - last.position);
    const double distance = moved.norm();
    const bool walks = distance > 1e-5 || std::abs(turned) > 1e-5;
    const double along = noise.next_normal();
    const double sideways = noise.next_normal();
    const double around = noise.next_normal();
    moved = scale * moved + settings.distance_noise * std::sqrt(distance) * Eigen::Vector2d(along, 0.5 * sideways);
    turned = heading_scale * turned + settings.heading_noise * std::sqrt(distance) * around + (walks ? drift * dt : 0);
    if (noise.next_uniform() < settings.slips_per_minute / 60 * dt && walks) {
      moved += settings.slip * Eigen::Vector2d(along, sideways);
      turned += settings.slip_heading * around;
    }
    heading += 0.5 * turned;
    position += Eigen::Rotation2Dd(heading) * moved;
    heading += 0.5 * turned;
    last = now;

    EncoderReading reading;
    reading.sample.stamp = stamp_at(start, i * dt);
    reading.sample.T_odom_base = {Eigen::Quaterniond(Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ())), {position.x(), position.y(), 0}};
    reading.sample.covariance.diagonal() << 1e-4, 1e-4, 0.01, 0.01, 0.01, 1e-3;
    reading.forward = moved.x() / dt;
    reading.sideways = moved.y() / dt;
    reading.turning = turned / dt;
    readings.push_back(reading);
  }
  return readings;
}

std::vector<ImuSample> simulate_imu(const Motion& motion, double duration, const ImuSettings& settings, std::uint64_t seed, std::int64_t start) {
  RandomStream biases(seed, static_cast<std::uint64_t>(Stream::imu_bias));
  RandomStream noise(seed, static_cast<std::uint64_t>(Stream::imu_noise));
  const auto draw = [](RandomStream& stream, double sigma) {
    Eigen::Vector3d v;
    for (int k = 0; k < 3; ++k) v[k] = sigma * stream.next_normal();
    return v;
  };
  const Eigen::Vector3d gyro_bias = draw(biases, settings.gyro_bias);
  const Eigen::Vector3d accel_bias = draw(biases, settings.accel_bias);
  const Eigen::Vector3d up(0, 0, settings.gravity);
  const double dt = 1 / settings.rate;
  const auto count = static_cast<int>(std::floor(duration / dt));
  std::vector<ImuSample> readings;
  for (int i = 0; i <= count; ++i) {
    const double t = i * dt;
    ImuSample sample;
    sample.stamp = stamp_at(start, t);
    sample.angular_velocity = motion.twist_at(t).head<3>() + gyro_bias + draw(noise, settings.gyro_noise);
    sample.linear_acceleration =
        motion.pose_at(t).rotation.conjugate() * (motion.acceleration_at(t) + up) + accel_bias + draw(noise, settings.accel_noise);
    readings.push_back(sample);
  }
  return readings;
}

}  // namespace sgraph::sim
