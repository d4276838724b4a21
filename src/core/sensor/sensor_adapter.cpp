#include "sgraph_slam/core/sensor/sensor_adapter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "azimuth.hpp"
#include "beam_check.hpp"
#include "time_field.hpp"
#include "times_from_azimuth.hpp"

namespace sgraph {
namespace {

constexpr std::size_t least_points = 50;  // that show whether a cloud lies on the beams
constexpr int refused_to_relearn = 10;    // clouds in a row that lie on none of the beams: it's the beams that are wrong
constexpr double usual_turn = 0.1;        // [s] as delivered, these sensors turn ten times a second

}  // namespace

void SensorAdapter::look(const RawScan& raw) {
  if (!decided_) recognition_.look(raw);
}

void SensorAdapter::settle() {
  if (decided_ || !recognition_.has_seen_any()) return;
  decided_ = true;
  conventions_ = recognition_.decide();
  recognition_ = SensorRecognition(params_);
}

AdaptedScans SensorAdapter::take(RawScan raw) {
  if (decided_) return adapt(std::move(raw));
  if (!recognition_.look(raw) && held_.empty()) return adapt(std::move(raw));  // shows nothing
  held_.push_back(std::move(raw));
  if (!recognition_.enough() && held_.size() < SensorRecognition::most_looks) return {};
  return flush();
}

AdaptedScans SensorAdapter::flush() {
  AdaptedScans result;
  settle();
  std::deque<RawScan> held = std::exchange(held_, {});
  for (RawScan& raw : held) {
    AdaptedScans one = decided_ ? adapt(std::move(raw)) : take(std::move(raw));  // undecided again: what is held shows that the beams are wrong
    result.scans.insert(result.scans.end(), one.scans.begin(), one.scans.end());
    if (one.fault != RawFault::none) result.fault = one.fault, result.text = one.text;
  }
  return result;
}

AdaptedScans SensorAdapter::adapt(RawScan raw) {
  AdaptedScans result;
  if (!on_beams(raw) && ++refused_ >= refused_to_relearn) {
    *this = SensorAdapter(params_);
    return take(std::move(raw));
  }
  if (refused_ > 0 && !on_beams(raw)) {
    result.fault = RawFault::beams;
    result.text = "the points lie on none of the sensor's beams: the cloud's layout isn't what its fields say, or another sensor took it";
    return result;
  }
  refused_ = 0;
  number_rings(raw);
  if (!set_times(raw, result.text)) {
    result.fault = RawFault::times;
    return result;
  }
  if (conventions_.description.slices && !raw.cloud.empty()) {
    const double turn = conventions_.description.turn > 0 ? conventions_.description.turn : usual_turn;
    if (!joiner_) joiner_.emplace(turn, conventions_.turn_sign);
    joiner_->add(std::move(raw.cloud), result.scans);
  } else {
    result.scans.push_back(std::make_shared<const Cloud>(std::move(raw.cloud)));
  }
  return result;
}

bool SensorAdapter::on_beams(const RawScan& raw) const {
  if (!conventions_.table || !conventions_.table->sharp || raw.cloud.size() < least_points) return true;
  return lies_on_beams(*conventions_.table, conventions_.description.ring_source == "field", raw.cloud);
}

void SensorAdapter::number_rings(RawScan& raw) const {
  if (conventions_.description.ring_source == "elevation" && conventions_.table) {
    for (Point& p : raw.cloud.points) p.ring = static_cast<std::uint16_t>(is_return(p) ? conventions_.table->nearest_row(p) : 0);
  } else if (params_.rings == "none") {
    for (Point& p : raw.cloud.points) p.ring = 0;
  }
}

bool SensorAdapter::set_times(RawScan& raw, std::string& error) const {
  auto& points = raw.cloud.points;
  const bool from_field = conventions_.description.time_source.rfind("field", 0) == 0;
  if (conventions_.description.time_source == "azimuth") {
    if (lies_on_cones(*conventions_.table, raw.cloud) || params_.times == "azimuth")
      times_from_azimuth(raw.cloud, conventions_.description.turn, conventions_.turn_sign, conventions_.stamp_fraction);
    return true;
  }
  if ((!from_field && decided_) || raw.times.empty()) return true;
  const bool named_absolute = !from_field && raw.time_field == "timestamp";
  const double unit = from_field ? conventions_.time_scale : named_absolute ? (raw.times.front() > 1e15 ? 1e-9 : 1.0) : named_unit(raw);
  const bool absolute = conventions_.description.time_origin == "absolute" || named_absolute;
  const bool own_clock = conventions_.description.time_origin == "on the sensor's own clock";
  double low = 0, high = 0;
  if (own_clock) {
    bool any = false;
    for (const double value : raw.times) {
      if (value == 0 || !std::isfinite(value)) continue;
      low = any ? std::min(low, value) : value;
      high = any ? std::max(high, value) : value;
      any = true;
    }
  }
  double largest = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double value = raw.times[i];
    if (!std::isfinite(value) || ((absolute || own_clock) && value == 0)) continue;  // of a point that is no return
    const double offset = own_clock  ? unit * (value - (conventions_.stamp_fraction == 0 ? low : high))
                          : absolute ? since(raw.cloud.stamp, value, unit)
                                     : unit * value;
    largest = std::max(largest, std::abs(offset));
    points[i].time = static_cast<float>(offset);
  }
  if (largest <= largest_time_offset) return true;
  error = "field " + raw.time_field + " puts points " + std::to_string(largest) + " s away from the cloud's stamp: another unit or clock";
  return false;
}

}  // namespace sgraph
