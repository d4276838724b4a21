#include "sgraph_slam/core/util/step_clock.hpp"

#include "sgraph_slam/core/util/resources.hpp"

namespace sgraph {

void StepClock::start() {
  milliseconds_.clear();
  last_ = thread_cpu_seconds();
}

void StepClock::book(const char* step) {
  const double now = thread_cpu_seconds();
  milliseconds_[step] += 1e3 * (now - last_);
  last_ = now;
}

}  // namespace sgraph
