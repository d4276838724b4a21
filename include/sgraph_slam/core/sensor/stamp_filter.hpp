#pragma once

#include <optional>
#include <vector>

#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph {

/// Tells a scan whose stamp is wrong from a clock that jumped or a recording that paused. A scan far in time from the one before it waits until
/// another one agrees with it; where the next one fits the one before instead, it is dropped. All other scans pass at once.
class StampFilter {
 public:
  enum class Backward {
    passes,   ///< a robot's time that goes back begins a new recording: for others to decide
    restamps  ///< in a recording whose clock was set back, the scans after it go on where those before it ended
  };
  explicit StampFilter(Backward backward) : backward_(backward) {}

  /// The scans that may pass, in order. `received`: when the message reached the computer, by the computer's clock.
  std::vector<CloudPtr> push(const CloudPtr& scan, const std::optional<Stamp>& received);
  /// Nothing more comes: what still waits agrees with nothing and is dropped.
  void finish();

  /// Scans dropped because of their stamps.
  [[nodiscard]] int dropped() const { return dropped_; }
  /// By how much stamps are moved since the clock was set back [s].
  [[nodiscard]] double shift() const { return shift_; }

  static constexpr double far = 5.0;  ///< [s] no sensor pauses so long between two scans, but clocks jump by less unnoticed

 private:
  struct Seen {
    CloudPtr scan;
    std::optional<Stamp> received;
  };
  [[nodiscard]] CloudPtr moved(const CloudPtr& scan) const;
  [[nodiscard]] static bool paused_between(const Seen& before, const Seen& after);

  Backward backward_;
  std::optional<Seen> last_;  // that passed
  double spacing_ = 0.1;      // of the last two scans [s]
  std::vector<Seen> waiting_;
  double shift_ = 0;
  int dropped_ = 0;
};

}  // namespace sgraph
