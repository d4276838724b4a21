#include "sgraph_slam/core/odometry/ride_height.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace sgraph {
namespace {

constexpr double gravity = 9.81;       // [m/s^2]
constexpr double longest = 300;        // [s] of a ride and of waiting in the cabin
constexpr double longest_hole = 0.1;   // [s] between readings: a lift changes its acceleration within half a second
constexpr std::size_t fewest = 50;     // readings
constexpr double smoothed_over = 0.5;  // [s]
constexpr double least_moving = 0.1;   // [m/s^2] that a smoothed reading is off where the cabin speeds up or slows down; lifts do so with 0.3 to 1.2
constexpr double before_and_after = 1.0;               // [s] of standing that belong to the ride
constexpr double bias_change = 0.003;                  // [m/s^2] during a ride, and of the unit's tilt
constexpr double least_share = 0.8, most_share = 1.2;  // of gravity, in m/s^2 or in g, that a unit reads at rest

}  // namespace

void RideHeight::add(const ImuSample& sample) {
  if (!sample.linear_acceleration.allFinite() || (!readings_.empty() && sample.stamp <= readings_.back().stamp)) return;
  readings_.push_back({sample.stamp, sample.linear_acceleration.norm()});
  // One that is too long leaves a ride whose beginning is missing.
  while (readings_.back().stamp - readings_.front().stamp > longest) readings_.pop_front();
}

void RideHeight::forget_before(Stamp stamp) {
  while (!readings_.empty() && readings_.front().stamp < stamp) readings_.pop_front();
}

std::optional<Rise> RideHeight::risen() const {
  const std::size_t count = readings_.size();
  if (count < fewest || readings_.back().stamp - readings_.front().stamp > longest - 1) return std::nullopt;
  std::vector<double> sorted;
  double noise = 0;  // mean square of the change from one reading to the next
  for (std::size_t i = 0; i < count; ++i) {
    sorted.push_back(readings_[i].norm);
    if (i == 0) continue;
    if (readings_[i].stamp - readings_[i - 1].stamp > longest_hole) return std::nullopt;
    noise += std::pow(readings_[i].norm - readings_[i - 1].norm, 2) / static_cast<double>(count - 1);
  }
  if (noise == 0) return std::nullopt;  // it is frozen
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count / 2), sorted.end());
  const double rest = sorted[count / 2];
  const auto reads = [rest](double unit) { return rest > least_share * unit && rest < most_share * unit; };
  if (!reads(gravity) && !reads(1)) return std::nullopt;  // gravity has been taken out, or another unit
  const double scale = gravity / rest;
  const auto time = [this](std::size_t i) { return readings_[i].stamp - readings_.front().stamp; };

  // The part in which the cabin moves, and a second of standing at both ends: noise and bias grow with the time.
  double moves_from = time(count - 1);
  double moves_until = 0;
  double sum = 0;
  for (std::size_t i = 0, first = 0; i < count; ++i) {
    sum += readings_[i].norm;
    while (time(i) - time(first) > smoothed_over) sum -= readings_[first++].norm;
    const double off = std::abs(sum / static_cast<double>(i - first + 1) - rest) * scale;
    if (time(i) < smoothed_over || off < least_moving) continue;
    moves_from = std::min(moves_from, time(first));
    moves_until = time(i);
  }
  std::size_t begin = 0;
  std::size_t end = count - 1;
  if (moves_from < moves_until) {
    while (time(begin + 1) <= moves_from - before_and_after) ++begin;
    while (time(end - 1) >= moves_until + before_and_after) --end;
  }

  const double duration = time(end) - time(begin);
  double mean = 0;
  const auto each_step = [&](const auto& step) {
    for (std::size_t i = begin; i < end; ++i) step(time(i + 1) - time(i), 0.5 * (readings_[i].norm + readings_[i + 1].norm));
  };
  each_step([&](double dt, double norm) { mean += norm * dt / duration; });
  double velocity = 0;
  Rise rise;
  each_step([&](double dt, double norm) {
    const double acceleration = gravity * (norm / mean - 1);
    rise.height += velocity * dt + 0.5 * acceleration * dt * dt;
    velocity += acceleration * dt;
  });
  const double density = 0.5 * noise * scale * scale * duration / static_cast<double>(end - begin);
  rise.sigma = std::sqrt(density * std::pow(duration, 3) / 12 + std::pow(bias_change * duration * duration / 12, 2));
  return rise;
}

}  // namespace sgraph
