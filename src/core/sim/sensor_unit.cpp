#include "sgraph_slam/core/sim/sensor_unit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "sgraph_slam/core/util/rng.hpp"
#include "streams.hpp"

namespace sgraph::sim {

namespace {

constexpr double degree = M_PI / 180;

// Piecewise linear through (x, y), constant beyond the ends.
template <std::size_t n>
double interpolate(const std::array<std::array<double, 2>, n>& knots, double x) {
  if (x <= knots.front()[0]) return knots.front()[1];
  for (std::size_t i = 1; i < n; ++i) {
    if (x > knots[i][0]) continue;
    const double f = (x - knots[i - 1][0]) / (knots[i][0] - knots[i - 1][0]);
    return knots[i - 1][1] + f * (knots[i][1] - knots[i - 1][1]);
  }
  return knots.back()[1];
}

}  // namespace

double SensorUnit::sine(int ring, std::int64_t firing) const {
  if (sine_amplitude == 0) return 0;
  const double cycles = std::fmod(static_cast<double>(firing) * sine_frequency, 1.0);
  return sine_amplitude * std::sin(2 * M_PI * cycles + sine_phase[static_cast<std::size_t>(ring)]);
}

SensorUnit real_unit(std::uint64_t unit) {
  // Two units had range offsets of 5 to 6 and 9.8 mm (standard deviation over the rings), between -15 and +18 mm; elevations up to 0.07 degrees.
  constexpr double lowest_offset = -0.015;
  constexpr double highest_offset = 0.018;
  constexpr double elevation_sigma = 0.03 * degree;
  constexpr double elevation_limit = 0.07 * degree;
  // A beam at elevation e leaves the axis at -41.8 mm tan(e): the manual's table 9-1 within its rounding to 0.1 mm.
  constexpr double crossing = 0.0418;
  RandomStream random(unit, static_cast<std::uint64_t>(Stream::sensor_unit));
  SensorUnit result;
  result.kind = SensorKind::real;
  result.unit = unit;
  const double spread = 0.005 + 0.005 * random.next_uniform();
  double mean = 0;
  for (double& offset : result.range_offset) {
    offset = std::min(highest_offset, std::max(lowest_offset, spread * random.next_normal()));
    mean += offset / SensorUnit::lasers;
  }
  for (double& offset : result.range_offset) offset -= mean;
  for (double& offset : result.elevation_offset)
    offset = std::min(elevation_limit, std::max(-elevation_limit, elevation_sigma * random.next_normal()));
  for (std::size_t ring = 0; ring < SensorUnit::lasers; ++ring) {
    result.origin_height[ring] = -crossing * std::tan((-15.0 + 2.0 * static_cast<double>(ring)) * degree);
  }
  result.sine_amplitude = 0.006 + 0.002 * random.next_uniform();
  for (double& phase : result.sine_phase) phase = 2 * M_PI * random.next_uniform();
  return result;
}

double white_noise(double intensity, double cosine) {
  const double angle = std::acos(std::min(1.0, cosine)) / degree;
  const double by_intensity = intensity >= 40 ? 0.0042 : intensity >= 5 ? 0.0046 : intensity >= 2 ? 0.0075 : 0.011;
  return by_intensity * interpolate<2>({{{30, 1.0}, {50, 1.25}}}, angle);
}

double intensity_bias(double intensity) { return interpolate<4>({{{5, -0.009}, {10, -0.009}, {30, -0.002}, {40, 0.0}}}, intensity); }

double mixed_pixel_share(double jump) {
  if (jump < 0.15) return 0;
  return jump < 0.3 ? 0.35 : jump < 0.5 ? 0.39 : jump < 0.8 ? 0.26 : jump < 1.3 ? 0.15 : jump < 2.5 ? 0.20 : 0;
}

}  // namespace sgraph::sim
