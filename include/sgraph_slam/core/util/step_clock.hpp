#pragma once

#include <map>
#include <string>

namespace sgraph {

/// What the steps of a piece of work take, for reports: CPU time of the calling thread from one booking to the next.
class StepClock {
 public:
  /// Forgets what was booked; the next booking counts from here.
  void start();
  /// Books the time since the last booking, or the start, under a step; what it has is added to.
  void book(const char* step);
  /// [ms]
  [[nodiscard]] const std::map<std::string, double>& milliseconds() const { return milliseconds_; }

 private:
  double last_ = 0;
  std::map<std::string, double> milliseconds_;
};

}  // namespace sgraph
