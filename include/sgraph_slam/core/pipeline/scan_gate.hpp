#pragma once

#include <deque>
#include <optional>

#include "sgraph_slam/core/pipeline/source.hpp"

namespace sgraph {

/// Lets odometry and inertial readings pass at once and holds each scan back until they cover it to its last firing: sensors reach a computer in
/// another order than that in which they measure. A scan is also released when anything later by more than `patience` has come, so that a sensor
/// that falls silent doesn't stop the rest. A scan stamped far ahead of the last one waits for the next: when that is earlier, the stamp was wrong,
/// the scan is dropped, and those after it aren't taken for late ones. Decides by stamps alone.
class ScanGate {
 public:
  ScanGate(bool wait_for_odometry, bool wait_for_imu, double patience = 0.5)
      : wait_for_odometry_(wait_for_odometry), wait_for_imu_(wait_for_imu), patience_(patience) {}

  void push(SensorEvent event);

  /// The next event that may pass; nothing while all are waiting.
  std::optional<SensorEvent> pop();

  /// Nothing more will come: every scan may pass.
  void close() { closed_ = true; }

  /// A scan that was dropped for its stamp since the last call, if any.
  std::optional<CloudPtr> take_dropped();

 private:
  struct Held {
    CloudPtr scan;
    Stamp end;
  };
  [[nodiscard]] bool covered(Stamp end) const;
  [[nodiscard]] bool far_ahead(Stamp stamp) const;
  void drop_refuted(Stamp stamp);

  bool wait_for_odometry_;
  bool wait_for_imu_;
  double patience_;
  bool closed_ = false;
  std::optional<Stamp> newest_odometry_;
  std::optional<Stamp> newest_imu_;
  std::optional<Stamp> newest_;  // of all
  std::deque<SensorEvent> passing_;
  std::deque<Held> held_;
  std::deque<CloudPtr> dropped_;
  std::optional<Stamp> last_scan_;  // that passed
};

/// Stamp of the scan's last firing; the cloud's own when its points carry no times.
Stamp last_firing(const Cloud& scan);

}  // namespace sgraph
