#include "sgraph_slam/core/sensor/recognition.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "azimuth.hpp"
#include "beam_check.hpp"
#include "sgraph_slam/core/util/statistics.hpp"
#include "time_field.hpp"

namespace sgraph {
namespace {

constexpr double covers_turn = 300 * M_PI / 180;  // a sensor looks past the robot's mast; a cloud of less is a slice or of a narrower sensor
constexpr int least_points = 50;                  // that show anything of the conventions
constexpr std::size_t sample_points = 60'000;     // from which the beams are learnt
constexpr std::size_t most_shown = 12;            // whole turns that are compared with each other
constexpr std::size_t looks_for_spacing = 4;      // clouds that tell the time between them
constexpr double longest_turn = 0.6;              // [s] 1.7 Hz
constexpr double shortest_turn = 0.02;            // [s] 50 Hz
constexpr double shortest_slice = 0.6e-3;         // [s] longest_turn / 1000: no two units fit
constexpr std::array<std::pair<const char*, double>, 4> units{{{"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}}};

}  // namespace

bool SensorRecognition::look(const RawScan& raw) {
  CloudLook seen = look_at(raw, std::nullopt);
  if (seen.points < least_points) return false;
  if (!sample_) {
    sample_ = raw;
  } else if (sample_->cloud.size() + raw.cloud.size() <= sample_points) {
    sample_->cloud.points.insert(sample_->cloud.points.end(), raw.cloud.points.begin(), raw.cloud.points.end());
  }
  if (shown_.size() < most_shown && seen.coverage > covers_turn) shown_.push_back(raw);
  if (!raw.has_ring) {  // the order shows only within a ring
    if (!table_) table_ = table_by_elevation(raw.cloud);
    if (!table_) table_ = table_by_elevation(sample_->cloud);
    seen = look_at(raw, table_);
  }
  looks_.push_back(seen);
  return true;
}

bool SensorRecognition::enough() const {
  if (looks_.empty()) return false;
  const CloudLook& last = looks_.back();
  if (last.coverage > covers_turn) {
    const bool field = sample_ && !sample_->time_field.empty() && params_.times != "azimuth";
    return field || params_.times == "none" || looks_.size() >= looks_for_spacing;
  }
  if (params_.slices == "keep" && sample_ && !sample_->time_field.empty()) return true;
  double advanced = 0;
  for (const CloudLook& look : looks_) advanced += std::abs(look.swept);
  return advanced > 1.3 * full_turn || last.stamp - looks_.front().stamp > 1.0 || looks_.size() >= most_looks;
}

SensorConventions SensorRecognition::decide() {
  if (!sample_) return std::move(result_);
  result_.description.intensity = sample_->has_intensity;
  decide_rings();
  for (CloudLook& look : looks_) result_.description.coverage_deg += look.coverage * 180 / M_PI / static_cast<double>(looks_.size());
  int clockwise = 0, counterclockwise = 0;
  for (const CloudLook& look : looks_) (look.swept < 0 ? clockwise : counterclockwise) += look.swept != 0;
  result_.turn_sign = clockwise > counterclockwise ? -1 : counterclockwise > 0 ? 1 : 0;
  // The azimuth alone can't tell the direction of clouds whose times run backwards; the order in the message is that of firing.
  if (params_.sweep != "auto") result_.turn_sign = params_.sweep == "clockwise" ? -1 : 1;
  decide_slices();
  decide_turn();
  decide_times();
  if (result_.turn_sign != 0) result_.description.sweep = result_.turn_sign < 0 ? "clockwise" : "counterclockwise";
  result_.table = std::move(table_);
  return std::move(result_);
}

// Of the tables that single turns give, the one on which most of the turns lie: a cloud that isn't what its fields say may be among them.
std::optional<RingTable> SensorRecognition::agreed_table(std::optional<RingTable> (*learn)(const Cloud&), bool by_field) const {
  std::optional<RingTable> best;
  int most = 0;
  for (const RawScan& candidate : shown_) {
    auto table = learn(candidate.cloud);
    if (!table || !table->sharp) continue;
    int agreeing = 0;
    for (const RawScan& other : shown_) agreeing += lies_on_beams(*table, by_field, other.cloud);
    if (agreeing <= most) continue;
    most = agreeing;
    best = std::move(table);
    if (2 * static_cast<std::size_t>(agreeing) > shown_.size()) break;
  }
  return best ? best : learn(sample_->cloud);
}

void SensorRecognition::decide_rings() {
  const bool wanted = params_.rings == "auto";
  std::optional<RingTable> by_field;
  if (sample_->has_ring && (wanted || params_.rings == "field")) by_field = agreed_table(table_by_ring, true);
  table_.reset();
  result_.description.ring_source = by_field ? "field" : "none";
  if (by_field) table_ = by_field;
  if ((wanted && !(by_field && by_field->sharp)) || params_.rings == "elevation") {
    const auto by_elevation = agreed_table(table_by_elevation, false);
    // Numbers that contradict the elevations are no ring numbers.
    if (by_elevation && (!by_field || (by_elevation->sharp && !by_field->sharp))) {
      table_ = by_elevation;
      result_.description.ring_source = "elevation";
    }
  }
  if (!table_) return;
  result_.description.model = model_of(*table_);
  result_.description.rings = table_->rows();
  for (const RingCone& cone : table_->cones) {
    result_.description.elevations_deg.push_back(std::atan(cone.slope) * 180 / M_PI);
    result_.description.vertical_offsets_m.push_back(cone.offset);
  }
  if (table_->sharp) result_.description.vertical_offsets = table_->from_one_point ? "absent" : "applied";
}

void SensorRecognition::decide_slices() {
  if (params_.slices != "auto") {
    result_.description.slices = params_.slices == "join";
    return;
  }
  if (looks_.size() < 3 || result_.description.coverage_deg * M_PI / 180 > covers_turn) return;
  int follows = 0, pairs = 0;
  for (std::size_t i = 1; i < looks_.size(); ++i) {
    const CloudLook& before = looks_[i - 1];
    const CloudLook& now = looks_[i];
    if (before.swept * now.swept <= 0) continue;
    ++pairs;
    const double gap = wrapped(now.begin - before.end) * (before.swept > 0 ? 1 : -1);
    follows += gap > -0.5 * std::abs(before.swept) && gap < std::abs(before.swept) + 0.05;
  }
  result_.description.slices = pairs >= 2 && 10 * follows >= 7 * pairs;
}

void SensorRecognition::decide_turn() {
  double& turn = result_.description.turn;
  if (params_.rate > 0) {
    turn = 1 / params_.rate;
    return;
  }
  std::vector<double> spacings;
  double advanced = 0;
  for (std::size_t i = 1; i < looks_.size(); ++i) {
    if (const double spacing = looks_[i].stamp - looks_[i - 1].stamp; spacing > 0) spacings.push_back(spacing);
    double step = result_.turn_sign * (looks_[i].begin - looks_[i - 1].begin);
    step -= full_turn * std::floor(step / full_turn);
    advanced += step;
  }
  const double elapsed = looks_.empty() ? 0 : looks_.back().stamp - looks_.front().stamp;
  if (result_.description.slices) {
    if (advanced > M_PI && elapsed > 0) turn = elapsed / advanced * full_turn;
    return;
  }
  const double spacing = upper_median(spacings);
  if (spacing > 0.045 && spacing < 0.21) turn = spacing;  // [s] spinning LiDARs turn 5 to 20 times a second
  const auto interval = firing_interval_of(result_.description.model);
  if (turn == 0 && interval && !looks_.empty() && looks_.front().step > 0) turn = *interval * full_turn / looks_.front().step;
  if (turn < 0.03 || turn > longest_turn) turn = 0;
}

void SensorRecognition::decide_stamp() {
  result_.description.stamp = params_.stamp == "auto" ? "last" : params_.stamp;
  if (params_.stamp == "auto") {
    // A cloud can't be received before its last firing. Recordings made by a converter are "received" at their stamps and tell nothing.
    std::optional<double> least;
    for (const CloudLook& look : looks_) {
      if (look.lag) least = std::min(least.value_or(*look.lag), *look.lag);
    }
    const double length = result_.description.slices ? result_.description.turn * result_.description.coverage_deg / 360 : result_.description.turn;
    if (least && length > 0 && *least > 0.9 * length && *least < 3 * length) result_.description.stamp = "first";
  }
  result_.stamp_fraction = result_.description.stamp == "first" ? 0 : 1;
}

// By the field of times, when there is one that can be times. Returns false when it can't.
bool SensorRecognition::decide_time_field() {
  std::vector<double> spans, firsts, trends;
  for (const CloudLook& look : looks_) {
    if (look.time_span > 0) spans.push_back(look.time_span), firsts.push_back(look.time_first), trends.push_back(look.time_trend);
  }
  if (spans.empty()) return false;
  const Stamp stamp = sample_->cloud.stamp;
  const double span = upper_median(spans);
  const double first = upper_median(firsts);
  const bool absolute = std::abs(first) > 50 * span;
  const double covered = std::max(result_.description.coverage_deg / 360, 0.01);
  const auto take = [&](const char* name, double unit, const char* origin) {
    result_.description.time_unit = name;
    result_.description.time_origin = origin;
    result_.time_scale = unit;
  };
  const auto is_wanted = [&](const char* name) { return params_.time_unit == "auto" || params_.time_unit == name; };
  const char* relative = absolute ? "on the sensor's own clock" : "from the stamp";
  // First the unit that the field's type stands for, then any that lets a turn last as long as turns do, then any that a slice could have.
  const auto by_turn = [&](double unit) { return span * unit > shortest_turn * covered && span * unit <= longest_turn * covered; };
  const auto by_span = [&](double unit) { return span * unit > shortest_slice && span * unit <= longest_turn; };
  for (const auto& [name, unit] : units) {
    if (absolute && is_wanted(name) && std::abs(since(stamp, first, unit)) < largest_time_offset) take(name, unit, "absolute");
  }
  for (const auto& [name, unit] : units) {
    if (result_.description.time_unit.empty() && params_.time_unit == name) take(name, unit, relative);
  }
  for (const bool named : {true, false}) {
    for (const auto& [name, unit] : units) {
      if (result_.description.time_unit.empty() && by_turn(unit) && (!named || unit == named_unit(*sample_))) take(name, unit, relative);
    }
  }
  for (const auto& [name, unit] : units) {
    if (result_.description.time_unit.empty() && by_span(unit)) take(name, unit, relative);
  }
  if (result_.description.time_unit.empty()) return false;
  result_.description.time_source = "field " + sample_->time_field;
  const bool backwards = upper_median(trends) < -0.9 && !looks_.front().by_ring;
  if (backwards && result_.description.time_origin == "from the stamp") {
    result_.time_scale = -result_.time_scale;
    result_.description.time_origin = "counted back from the stamp";
  }
  if (result_.description.time_origin != "on the sensor's own clock") {
    double low = std::abs(first) > 50 * span ? since(stamp, first, result_.time_scale) : first * result_.time_scale;
    double high = low + span * result_.time_scale;
    if (low > high) std::swap(low, high);
    const double tenth = 0.1 * (high - low);
    result_.description.stamp = low > -tenth ? "first" : high < tenth ? "last" : "inside";
    if (low > high + tenth || high < -1.0) result_.description.stamp = "inside";
  }
  if (result_.description.turn == 0 && !result_.description.slices) result_.description.turn = std::abs(span * result_.time_scale);
  return true;
}

void SensorRecognition::decide_times() {
  decide_stamp();
  if ((params_.times == "auto" || params_.times == "field") && decide_time_field()) return;
  // All zero: somebody has taken the motion out. All the same number: nobody knows what.
  const bool zero_field = !sample_->time_field.empty() && std::all_of(looks_.begin(), looks_.end(), [](const CloudLook& look) {
    return look.time_span <= 0 && look.time_first == 0;
  });
  const bool azimuth_wanted = params_.times == "azimuth" || (params_.times == "auto" && !zero_field);
  const bool in_order = result_.turn_sign != 0 && !looks_.empty() && table_ && (table_->sharp || params_.times == "azimuth");
  if (azimuth_wanted && in_order) {
    if (result_.description.turn == 0) result_.description.turn = 0.1;  // [s] as delivered, these sensors turn ten times a second
    result_.description.time_source = "azimuth";
  } else {
    result_.description.stamp = "unknown";
  }
}

}  // namespace sgraph
