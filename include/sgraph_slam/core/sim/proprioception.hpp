#pragma once

#include <cstdint>
#include <vector>

#include "sgraph_slam/core/sim/motion.hpp"
#include "sgraph_slam/core/types/sensor.hpp"

namespace sgraph::sim {

/// Errors of the robot's own odometry. Scale, heading and bias errors are drawn once a run from normal distributions with these sigmas.
struct EncoderSettings {
  double rate = 50;               ///< [Hz]
  double scale = 0.012;           ///< relative, of the distance
  double heading_scale = 0.01;    ///< relative, of the turned angle
  double heading_drift = 0.0007;  ///< while it walks [rad/s]
  double distance_noise = 0.01;   ///< [m / sqrt(m)]
  double heading_noise = 0.004;   ///< [rad / sqrt(m)]
  double slips_per_minute = 1.0;  ///< moments in which the feet slide ...
  double slip = 0.03;             ///< ... by this much [m], and
  double slip_heading = 0.01;     ///< [rad]
};

struct ImuSettings {
  double rate = 100;          ///< [Hz]
  double gyro_noise = 0.003;  ///< of one reading [rad/s]
  double gyro_bias = 0.003;   ///< [rad/s]
  double accel_noise = 0.04;  ///< of one reading [m/s^2]
  double accel_bias = 0.03;   ///< [m/s^2]
  double gravity = 9.81;      ///< [m/s^2]
};

/// A reading of the odometry with the velocity that it claims.
struct EncoderReading {
  OdometrySample sample;
  double forward = 0;   ///< [m/s]
  double sideways = 0;  ///< [m/s]
  double turning = 0;   ///< [rad/s]
};

/// Pose in `odom` dead-reckoned from disturbed steps of the true planar motion; starts at the identity. `start`: stamp of time 0 [ns].
std::vector<EncoderReading> simulate_encoders(const Motion& motion, double duration, const EncoderSettings& settings, std::uint64_t seed,
                                              std::int64_t start);

/// Readings in the base frame: rates and specific force with bias and white noise.
std::vector<ImuSample> simulate_imu(const Motion& motion, double duration, const ImuSettings& settings, std::uint64_t seed, std::int64_t start);

}  // namespace sgraph::sim
