#pragma once

#include <cstdint>

namespace sgraph::sim {

/// One stream of random numbers a purpose, so that one setting doesn't change another's noise.
enum class Stream : std::uint64_t {
  range = 1,
  detection = 2,
  glass = 3,
  intensity = 4,
  odometry_errors = 5,
  odometry_noise = 6,
  imu_bias = 7,
  imu_noise = 8,
  sensor_unit = 9,
  texture = 10,
  mixed_pixel = 11,
  colour = 12,
  building = 13,
  session = 14
};

}  // namespace sgraph::sim
