#pragma once

#include <chrono>

namespace sgraph {

/// Wall time, for reports; never for decisions.
class Stopwatch {
 public:
  /// Milliseconds since the construction or the last lap, which starts the next.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double milliseconds = std::chrono::duration<double, std::milli>(now - start_).count();
    start_ = now;
    return milliseconds;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace sgraph
