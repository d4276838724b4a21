#pragma once

#include <cmath>
#include <cstdint>

namespace sgraph {

/// A point in time: whole nanoseconds since the epoch of the recording's clock. Exact, so that the parts of one scan match by equality.
struct Stamp {
  std::int64_t nanoseconds = 0;

  static Stamp from_seconds(double seconds) { return {static_cast<std::int64_t>(std::llround(seconds * 1e9))}; }
  /// Seconds as a double: good to about 0.2 microseconds for present-day stamps. Subtract stamps first where more is needed.
  [[nodiscard]] double seconds() const { return static_cast<double>(nanoseconds) * 1e-9; }

  /// The stamp `seconds` later (earlier when negative).
  [[nodiscard]] Stamp after(double seconds) const { return {nanoseconds + from_seconds(seconds).nanoseconds}; }

  friend bool operator==(Stamp a, Stamp b) { return a.nanoseconds == b.nanoseconds; }
  friend bool operator!=(Stamp a, Stamp b) { return a.nanoseconds != b.nanoseconds; }
  friend bool operator<(Stamp a, Stamp b) { return a.nanoseconds < b.nanoseconds; }
  friend bool operator<=(Stamp a, Stamp b) { return a.nanoseconds <= b.nanoseconds; }
  friend bool operator>(Stamp a, Stamp b) { return b < a; }
  friend bool operator>=(Stamp a, Stamp b) { return b <= a; }
};

/// Seconds from `b` to `a`.
inline double operator-(Stamp a, Stamp b) { return static_cast<double>(a.nanoseconds - b.nanoseconds) * 1e-9; }

}  // namespace sgraph
