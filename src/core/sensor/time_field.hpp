#pragma once

#include <cstdint>

#include "sgraph_slam/core/sensor/raw_scan.hpp"

namespace sgraph {

/// Largest offset of a point's time from its cloud's stamp [s]: a larger one is another unit or another clock.
constexpr double largest_time_offset = 2.0;

/// The time [s] from the cloud's stamp of an absolute value in units of `unit` [s]; whole seconds are taken off first, which keeps the fraction of a
/// microsecond.
inline double since(Stamp stamp, double value, double unit) {
  constexpr std::int64_t billion = 1'000'000'000;
  const std::int64_t seconds = stamp.nanoseconds / billion;
  const auto whole = static_cast<double>(seconds);
  const auto rest = static_cast<double>(stamp.nanoseconds % billion);
  return (unit == 1.0 ? value - whole : unit * (value - whole / unit)) - 1e-9 * rest;
}

/// The unit that the type of a field of times stands for [s]: integers count nanoseconds.
inline double named_unit(const RawScan& raw) { return raw.integer_times ? 1e-9 : 1.0; }

}  // namespace sgraph
