#include "sgraph_slam/core/pipeline/scan_gate.hpp"

#include <algorithm>

namespace sgraph {
namespace {

constexpr double far = 10.0;  // [s] between scans: a longer pause is believed when a second scan says so too

void advance(std::optional<Stamp>& newest, Stamp stamp) {
  if (!newest || stamp > *newest) newest = stamp;
}

}  // namespace

Stamp last_firing(const Cloud& scan) {
  if (scan.empty()) return scan.stamp;
  float last = scan.points.front().time;
  for (const Point& point : scan.points) last = std::max(last, point.time);
  return scan.stamp.after(static_cast<double>(last));
}

void ScanGate::push(SensorEvent event) {
  if (const auto* scan = std::get_if<CloudPtr>(&event)) {
    drop_refuted((*scan)->stamp);
    if (!held_.empty() || !far_ahead((*scan)->stamp)) advance(newest_, (*scan)->stamp);
    held_.push_back({*scan, last_firing(**scan)});
    return;
  }
  if (const auto* odometry = std::get_if<OdometrySample>(&event)) {
    advance(newest_odometry_, odometry->stamp);
    advance(newest_, odometry->stamp);
  } else {
    const Stamp stamp = std::get<ImuSample>(event).stamp;
    advance(newest_imu_, stamp);
    advance(newest_, stamp);
  }
  passing_.push_back(std::move(event));
}

bool ScanGate::covered(Stamp end) const {
  if (closed_ || *newest_ - end > patience_) return true;
  const bool odometry = !wait_for_odometry_ || (newest_odometry_ && *newest_odometry_ >= end);
  const bool imu = !wait_for_imu_ || (newest_imu_ && *newest_imu_ >= end);
  return odometry && imu;
}

std::optional<SensorEvent> ScanGate::pop() {
  if (!passing_.empty()) {
    SensorEvent event = std::move(passing_.front());
    passing_.pop_front();
    return event;
  }
  if (held_.empty()) return std::nullopt;
  const bool unconfirmed = held_.size() == 1 && far_ahead(held_.front().scan->stamp) && !closed_;
  if (unconfirmed || !covered(held_.front().end)) return std::nullopt;
  CloudPtr scan = std::move(held_.front().scan);
  held_.pop_front();
  advance(last_scan_, scan->stamp);
  return scan;
}

std::optional<CloudPtr> ScanGate::take_dropped() {
  if (dropped_.empty()) return std::nullopt;
  CloudPtr scan = std::move(dropped_.front());
  dropped_.pop_front();
  return scan;
}

// Ahead of the scan before it, held or passed.
bool ScanGate::far_ahead(Stamp stamp) const { return last_scan_ && stamp - *last_scan_ > far; }

// A scan that isn't late itself refutes those before it that are later.
void ScanGate::drop_refuted(Stamp stamp) {
  while (last_scan_ && stamp > *last_scan_ && !held_.empty() && held_.back().scan->stamp > stamp && far_ahead(held_.back().scan->stamp)) {
    dropped_.push_back(std::move(held_.back().scan));
    held_.pop_back();
  }
}

}  // namespace sgraph
