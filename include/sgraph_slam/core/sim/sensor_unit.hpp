#pragma once

#include <array>
#include <cstdint>

namespace sgraph::sim {

enum class SensorKind { ideal, real };

/// The systematic errors of one VLP-16, as measured on real ones (docs/simulator.md, The real sensor). All zero: the ideal sensor.
struct SensorUnit {
  static constexpr int lasers = 16;

  SensorKind kind = SensorKind::ideal;
  std::uint64_t unit = 0;                         ///< number from which the errors were drawn
  std::array<double, lasers> range_offset{};      ///< by ring, reported minus true [m]; mean zero
  std::array<double, lasers> elevation_offset{};  ///< by ring, true minus reported elevation of the beam [rad]
  std::array<double, lasers> origin_height{};     ///< by ring, of the laser's origin on the axis above the sensor's [m]; the cloud leaves it out
  double sine_amplitude = 0;                      ///< of the periodic range error [m]
  std::array<double, lasers> sine_phase{};        ///< by ring, at firing 0 [rad]

  /// The periodic part of the range error [m].
  [[nodiscard]] double sine(int ring, std::int64_t firing) const;
};

/// Period of the sine: cycles a firing.
constexpr double sine_frequency = 0.2002;

/// Draws the errors of a unit; unit n is the same for ever.
SensorUnit real_unit(std::uint64_t unit);

/// Standard deviation of the white part of the range error of a real sensor [m]. `cosine` of the angle of incidence.
double white_noise(double intensity, double cosine);

/// Mean range error of a real sensor as a function of the reported intensity [m].
double intensity_bias(double intensity);

/// The share of the edges at which a point floats between the two surfaces, by the jump of the range across the edge [m].
double mixed_pixel_share(double jump);

}  // namespace sgraph::sim
