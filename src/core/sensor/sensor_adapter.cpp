#include "sgraph_slam/core/sensor/sensor_adapter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {
namespace {

constexpr double full_turn = 2 * M_PI;
constexpr double covers_turn = 300 * M_PI / 180;  // a sensor looks past the robot's mast; a cloud of less is a slice or of a narrower sensor
constexpr int least_points = 50;                  // that show anything of the conventions
constexpr std::size_t sample_points = 60'000;     // from which the beams are learnt
constexpr std::size_t most_shown = 12;            // whole turns that are compared with each other
constexpr int refused_to_relearn = 10;            // clouds in a row that lie on none of the beams: it's the beams that are wrong
constexpr std::size_t looks_for_spacing = 4;      // clouds that tell the time between them
constexpr double largest_offset = 2.0;            // [s] from the stamp; a larger one is another unit or clock
constexpr double longest_turn = 0.6;              // [s] 1.7 Hz
constexpr double shortest_turn = 0.02;            // [s] 50 Hz
constexpr double shortest_slice = 0.6e-3;         // [s] longest_turn / 1000: no two units fit
constexpr std::array<std::pair<const char*, double>, 4> units{{{"s", 1.0}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}}};

double wrapped(double angle) { return std::remainder(angle, full_turn); }

bool valid(const Point& p) {
  const double rho = std::hypot(static_cast<double>(p.x), static_cast<double>(p.y));
  return std::isfinite(rho) && std::isfinite(p.z) && rho > 0.05;
}
double azimuth_of(const Point& p) { return std::atan2(static_cast<double>(p.y), static_cast<double>(p.x)); }

// The time [s] from the cloud's stamp of an absolute value; whole seconds are taken off first, which keeps the fraction of a microsecond.
double since(Stamp stamp, double value, double unit) {
  constexpr std::int64_t billion = 1'000'000'000;
  const std::int64_t seconds = stamp.nanoseconds / billion;
  const auto whole = static_cast<double>(seconds);
  const auto rest = static_cast<double>(stamp.nanoseconds % billion);
  return (unit == 1.0 ? value - whole : unit * (value - whole / unit)) - 1e-9 * rest;
}

double named_unit(const RawScan& raw) { return raw.integer_times ? 1e-9 : 1.0; }

// Share of neighbours in the message that have the same ring.
bool ordered_by_ring(const std::vector<Point>& points) {
  std::size_t same = 0;
  for (std::size_t i = 1; i < points.size(); ++i) same += points[i].ring == points[i - 1].ring;
  return 2 * same > points.size();
}

double elevation_error(const RingTable& table, const Point& p, int row) {
  const double rho = std::hypot(static_cast<double>(p.x), static_cast<double>(p.y));
  const RingCone& cone = table.cones[static_cast<std::size_t>(row)];
  return std::abs(std::atan2(static_cast<double>(p.z) - cone.offset, rho) - std::atan(cone.slope));
}

double distance_to_cone(const RingTable& table, const Point& p) {
  const double rho = std::hypot(static_cast<double>(p.x), static_cast<double>(p.y));
  const RingCone& cone = table.cones[static_cast<std::size_t>(table.nearest_row(p))];
  return std::abs(static_cast<double>(p.z) - cone.slope * rho - cone.offset);
}

// Whether the points lie on the sensor's cones as they do when nobody has moved them since.
bool lies_on_cones(const RingTable& table, const Cloud& cloud) {
  std::vector<double> away;
  const std::size_t stride = std::max<std::size_t>(1, cloud.size() / 400);
  for (std::size_t i = 0; i < cloud.size(); i += stride) {
    if (valid(cloud.points[i])) away.push_back(distance_to_cone(table, cloud.points[i]));
  }
  return !away.empty() && upper_median(away) < 0.003;  // [m] drivers round to millimetres; a turn's motion is centimetres
}

// Whether most points are at the elevation of a beam, of their own where the cloud numbers them.
bool lies_on_beams(const RingTable& table, bool by_field, const Cloud& cloud) {
  const double span = std::atan(table.cones.back().slope) - std::atan(table.cones.front().slope);
  const double allowed = std::max(0.5 * span / std::max(1, table.rows() - 1), 0.02);  // [rad] half the spacing, or a degree
  std::vector<double> errors;
  const std::size_t stride = std::max<std::size_t>(1, cloud.size() / 400);
  std::size_t looked_at = 0;
  for (std::size_t i = 0; i < cloud.size(); i += stride) {
    const Point& p = cloud.points[i];
    ++looked_at;
    if (!valid(p) || std::hypot(static_cast<double>(p.x), static_cast<double>(p.y)) < 0.5) continue;
    const bool known = p.ring < table.row_of_ring.size() && table.row_of_ring[p.ring] >= 0;
    if (by_field && !known) {
      errors.push_back(M_PI);  // a beam that the sensor doesn't have
      continue;
    }
    errors.push_back(elevation_error(table, p, by_field ? table.row_of_ring[p.ring] : table.nearest_row(p)));
  }
  if (errors.size() < 20) return true;  // all but empty: for others to judge
  return upper_median(errors) < allowed;
}

}  // namespace

SensorAdapter::Look SensorAdapter::look_at(const RawScan& raw, const std::optional<RingTable>& table) {
  Look look;
  look.stamp = raw.cloud.stamp;
  if (raw.received) look.lag = *raw.received - raw.cloud.stamp;
  struct Row {
    double azimuth = 0, swept = 0, time = 0;
    int points = 0;
  };
  std::vector<Row> rows;
  std::array<bool, 360> seen{};
  std::vector<double> forward, backward;
  int later = 0, earlier = 0;
  std::size_t same_ring = 0;
  int last_row = -1;
  double low = 0, high = 0;
  for (std::size_t i = 0; i < raw.cloud.size(); ++i) {
    const Point& p = raw.cloud.points[i];
    if (!valid(p)) continue;
    const double azimuth = azimuth_of(p);
    const int row = table && !raw.has_ring ? table->nearest_row(p) : p.ring;
    if (static_cast<std::size_t>(row) >= rows.size()) rows.resize(static_cast<std::size_t>(row) + 1);
    Row& own = rows[static_cast<std::size_t>(row)];
    same_ring += row == last_row;
    last_row = row;
    seen[static_cast<std::size_t>((azimuth + M_PI) / full_turn * 359.999)] = true;
    if (look.points == 0) look.begin = azimuth;
    look.end = azimuth;
    const double time = raw.times.empty() ? 0.0 : raw.times[i];
    if (own.points > 0) {
      const double step = wrapped(azimuth - own.azimuth);
      own.swept += step;
      if (std::abs(step) > 1e-6 && std::abs(step) < 0.35) (step > 0 ? forward : backward).push_back(std::abs(step));
      later += time > own.time;
      earlier += time < own.time;
    }
    if (std::isfinite(time) && time != 0) {
      if (low == 0 && high == 0) low = high = time;
      low = std::min(low, time);
      high = std::max(high, time);
    }
    own.azimuth = azimuth;
    own.time = time;
    ++own.points;
    ++look.points;
  }
  if (look.points == 0) return look;
  look.by_ring = 2 * same_ring > static_cast<std::size_t>(look.points);
  // Relative times may begin with a 0, which a missing return has too; absolute ones never are.
  const bool relative = low > 0 && low < high - low;
  look.time_first = relative ? 0 : low;
  look.time_span = high - look.time_first;
  if (low < 0 && high < 0 && -high < high - low) look.time_span = -low;
  if (later + earlier > 0) look.time_trend = static_cast<double>(later - earlier) / (later + earlier);
  int gap = 0, largest = 0;
  for (std::size_t i = 0; i < 2 * seen.size(); ++i) {
    gap = seen[i % seen.size()] ? 0 : gap + 1;
    largest = std::max(largest, std::min(gap, 360));
  }
  look.coverage = (360 - largest) * M_PI / 180;
  const std::size_t steps = forward.size() + backward.size();
  const bool counter_clockwise = forward.size() > backward.size();
  if (steps >= 20 && std::max(forward.size(), backward.size()) > 9 * steps / 10) {
    std::vector<double> swept;
    int most = 0;
    for (const Row& row : rows) most = std::max(most, row.points);
    for (const Row& row : rows) {
      if (2 * row.points >= most) swept.push_back(row.swept);
    }
    look.swept = upper_median(swept);
    if ((look.swept > 0) != counter_clockwise) look.swept = counter_clockwise ? look.coverage : -look.coverage;  // a gap of more than half a turn
    look.step = upper_median(counter_clockwise ? forward : backward);
  }
  look.sharp = table && table->sharp;
  return look;
}

void SensorAdapter::look(const RawScan& raw) {
  if (decided_) return;
  Look seen = look_at(raw, std::nullopt);
  if (seen.points < least_points) return;
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
}

void SensorAdapter::settle() {
  if (!decided_ && !looks_.empty()) decide();
}

bool SensorAdapter::enough() const {
  if (looks_.empty()) return false;
  const Look& last = looks_.back();
  if (last.coverage > covers_turn) {
    const bool field = sample_ && !sample_->time_field.empty() && params_.times != "azimuth";
    return field || params_.times == "none" || looks_.size() >= looks_for_spacing;
  }
  if (params_.slices == "keep" && sample_ && !sample_->time_field.empty()) return true;
  double advanced = 0;
  for (const Look& look : looks_) advanced += std::abs(look.swept);
  return advanced > 1.3 * full_turn || last.stamp - looks_.front().stamp > 1.0 || looks_.size() >= most_held;
}

void SensorAdapter::decide() {
  decided_ = true;
  if (!sample_) return;
  description_.intensity = sample_->has_intensity;
  decide_rings();
  for (Look& look : looks_) description_.coverage_deg += look.coverage * 180 / M_PI / static_cast<double>(looks_.size());
  int clockwise = 0, counterclockwise = 0;
  for (const Look& look : looks_) (look.swept < 0 ? clockwise : counterclockwise) += look.swept != 0;
  turn_sign_ = clockwise > counterclockwise ? -1 : counterclockwise > 0 ? 1 : 0;
  // The azimuth alone can't tell the direction of clouds whose times run backwards; the order in the message is that of firing.
  if (params_.sweep != "auto") turn_sign_ = params_.sweep == "clockwise" ? -1 : 1;
  decide_slices();
  decide_turn();
  decide_times();
  if (turn_sign_ != 0) description_.sweep = turn_sign_ < 0 ? "clockwise" : "counterclockwise";
  sample_.reset();
  shown_.clear();
}

// Of the tables that single turns give, the one on which most of the turns lie: a cloud that isn't what its fields say may be among them.
std::optional<RingTable> SensorAdapter::agreed_table(std::optional<RingTable> (*learn)(const Cloud&), bool by_field) const {
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

void SensorAdapter::decide_rings() {
  const bool wanted = params_.rings == "auto";
  std::optional<RingTable> by_field;
  if (sample_->has_ring && (wanted || params_.rings == "field")) by_field = agreed_table(table_by_ring, true);
  table_.reset();
  description_.ring_source = by_field ? "field" : "none";
  if (by_field) table_ = by_field;
  if ((wanted && !(by_field && by_field->sharp)) || params_.rings == "elevation") {
    const auto by_elevation = agreed_table(table_by_elevation, false);
    // Numbers that contradict the elevations are no ring numbers.
    if (by_elevation && (!by_field || (by_elevation->sharp && !by_field->sharp))) {
      table_ = by_elevation;
      description_.ring_source = "elevation";
    }
  }
  if (!table_) return;
  description_.model = model_of(*table_);
  description_.rings = table_->rows();
  for (const RingCone& cone : table_->cones) {
    description_.elevations_deg.push_back(std::atan(cone.slope) * 180 / M_PI);
    description_.vertical_offsets_m.push_back(cone.offset);
  }
  if (table_->sharp) description_.vertical_offsets = table_->from_one_point ? "absent" : "applied";
}

void SensorAdapter::decide_slices() {
  if (params_.slices != "auto") {
    description_.slices = params_.slices == "join";
    return;
  }
  if (looks_.size() < 3 || description_.coverage_deg * M_PI / 180 > covers_turn) return;
  int follows = 0, pairs = 0;
  for (std::size_t i = 1; i < looks_.size(); ++i) {
    const Look& before = looks_[i - 1];
    const Look& now = looks_[i];
    if (before.swept * now.swept <= 0) continue;
    ++pairs;
    const double gap = wrapped(now.begin - before.end) * (before.swept > 0 ? 1 : -1);
    follows += gap > -0.5 * std::abs(before.swept) && gap < std::abs(before.swept) + 0.05;
  }
  description_.slices = pairs >= 2 && 10 * follows >= 7 * pairs;
}

void SensorAdapter::decide_turn() {
  double& turn = description_.turn;
  if (params_.rate > 0) {
    turn = 1 / params_.rate;
    return;
  }
  std::vector<double> spacings;
  double advanced = 0;
  for (std::size_t i = 1; i < looks_.size(); ++i) {
    if (const double spacing = looks_[i].stamp - looks_[i - 1].stamp; spacing > 0) spacings.push_back(spacing);
    double step = turn_sign_ * (looks_[i].begin - looks_[i - 1].begin);
    step -= full_turn * std::floor(step / full_turn);
    advanced += step;
  }
  const double elapsed = looks_.empty() ? 0 : looks_.back().stamp - looks_.front().stamp;
  if (description_.slices) {
    if (advanced > M_PI && elapsed > 0) turn = elapsed / advanced * full_turn;
    return;
  }
  const double spacing = upper_median(spacings);
  if (spacing > 0.045 && spacing < 0.21) turn = spacing;  // [s] spinning LiDARs turn 5 to 20 times a second
  const auto interval = firing_interval_of(description_.model);
  if (turn == 0 && interval && !looks_.empty() && looks_.front().step > 0) turn = *interval * full_turn / looks_.front().step;
  if (turn < 0.03 || turn > longest_turn) turn = 0;
}

void SensorAdapter::decide_times() {
  std::vector<double> spans, firsts, trends;
  for (const Look& look : looks_) {
    if (look.time_span > 0) spans.push_back(look.time_span), firsts.push_back(look.time_first), trends.push_back(look.time_trend);
  }
  const Stamp stamp = sample_->cloud.stamp;
  description_.stamp = params_.stamp == "auto" ? "last" : params_.stamp;
  if (params_.stamp == "auto") {
    // A cloud can't be received before its last firing. Recordings made by a converter are "received" at their stamps and tell nothing.
    std::optional<double> least;
    for (const Look& look : looks_) {
      if (look.lag) least = std::min(least.value_or(*look.lag), *look.lag);
    }
    const double length = description_.slices ? description_.turn * description_.coverage_deg / 360 : description_.turn;
    if (least && length > 0 && *least > 0.9 * length && *least < 3 * length) description_.stamp = "first";
  }
  stamp_fraction_ = description_.stamp == "first" ? 0 : 1;

  const bool field_wanted = params_.times == "auto" || params_.times == "field";
  if (field_wanted && !spans.empty()) {
    const double span = upper_median(spans);
    const double first = upper_median(firsts);
    const bool absolute = std::abs(first) > 50 * span;
    const double covered = std::max(description_.coverage_deg / 360, 0.01);
    const auto take = [&](const char* name, double unit, const char* origin) {
      description_.time_unit = name;
      description_.time_origin = origin;
      time_scale_ = unit;
    };
    const auto is_wanted = [&](const char* name) { return params_.time_unit == "auto" || params_.time_unit == name; };
    const char* relative = absolute ? "on the sensor's own clock" : "from the stamp";
    // First the unit that the field's type stands for, then any that lets a turn last as long as turns do, then any that a slice could have.
    const auto by_turn = [&](double unit) { return span * unit > shortest_turn * covered && span * unit <= longest_turn * covered; };
    const auto by_span = [&](double unit) { return span * unit > shortest_slice && span * unit <= longest_turn; };
    for (const auto& [name, unit] : units) {
      if (absolute && is_wanted(name) && std::abs(since(stamp, first, unit)) < largest_offset) take(name, unit, "absolute");
    }
    for (const auto& [name, unit] : units) {
      if (description_.time_unit.empty() && params_.time_unit == name) take(name, unit, relative);
    }
    for (const bool named : {true, false}) {
      for (const auto& [name, unit] : units) {
        if (description_.time_unit.empty() && by_turn(unit) && (!named || unit == named_unit(*sample_))) take(name, unit, relative);
      }
    }
    for (const auto& [name, unit] : units) {
      if (description_.time_unit.empty() && by_span(unit)) take(name, unit, relative);
    }
    if (!description_.time_unit.empty()) {
      description_.time_source = "field " + sample_->time_field;
      const bool backwards = upper_median(trends) < -0.9 && !looks_.front().by_ring;
      if (backwards && description_.time_origin == "from the stamp") {
        time_scale_ = -time_scale_;
        description_.time_origin = "counted back from the stamp";
      }
      if (description_.time_origin != "on the sensor's own clock") {
        double low = std::abs(first) > 50 * span ? since(stamp, first, time_scale_) : first * time_scale_;
        double high = low + span * time_scale_;
        if (low > high) std::swap(low, high);
        const double tenth = 0.1 * (high - low);
        description_.stamp = low > -tenth ? "first" : high < tenth ? "last" : "inside";
        if (low > high + tenth || high < -1.0) description_.stamp = "inside";
      }
      if (description_.turn == 0 && !description_.slices) description_.turn = std::abs(span * time_scale_);
      return;
    }
  }
  // All zero: somebody has taken the motion out. All the same number: nobody knows what.
  const bool zero_field = !sample_->time_field.empty() && spans.empty() &&
                          std::all_of(looks_.begin(), looks_.end(), [](const Look& look) { return look.time_first == 0; });
  const bool azimuth_wanted = params_.times == "azimuth" || (params_.times == "auto" && !zero_field);
  const bool in_order = turn_sign_ != 0 && !looks_.empty() && table_ && (table_->sharp || params_.times == "azimuth");
  if (azimuth_wanted && in_order) {
    if (description_.turn == 0) description_.turn = 0.1;  // [s] as delivered, these sensors turn ten times a second
    description_.time_source = "azimuth";
  } else {
    description_.stamp = "unknown";
  }
}

AdaptedScans SensorAdapter::take(RawScan raw) {
  if (decided_) return adapt(std::move(raw));
  const std::size_t before = looks_.size();
  look(raw);
  if (looks_.size() == before && held_.empty()) return adapt(std::move(raw));  // shows nothing
  held_.push_back(std::move(raw));
  if (!enough() && held_.size() < most_held) return {};
  return flush();
}

AdaptedScans SensorAdapter::flush() {
  AdaptedScans result;
  settle();
  for (RawScan& raw : held_) {
    AdaptedScans one = adapt(std::move(raw));
    result.scans.insert(result.scans.end(), one.scans.begin(), one.scans.end());
    if (one.fault != RawFault::none) result.fault = one.fault, result.text = one.text;
  }
  held_.clear();
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
  if (description_.slices && !raw.cloud.empty()) {
    join(std::move(raw.cloud), result.scans);
  } else {
    result.scans.push_back(std::make_shared<const Cloud>(std::move(raw.cloud)));
  }
  return result;
}

bool SensorAdapter::on_beams(const RawScan& raw) const {
  if (!table_ || !table_->sharp || raw.cloud.size() < static_cast<std::size_t>(least_points)) return true;
  return lies_on_beams(*table_, description_.ring_source == "field", raw.cloud);
}

void SensorAdapter::number_rings(RawScan& raw) const {
  if (description_.ring_source == "elevation" && table_) {
    for (Point& p : raw.cloud.points) p.ring = static_cast<std::uint16_t>(valid(p) ? table_->nearest_row(p) : 0);
  } else if (params_.rings == "none") {
    for (Point& p : raw.cloud.points) p.ring = 0;
  }
}

bool SensorAdapter::set_times(RawScan& raw, std::string& error) const {
  auto& points = raw.cloud.points;
  const bool from_field = description_.time_source.rfind("field", 0) == 0;
  if (description_.time_source == "azimuth") {
    if (lies_on_cones(*table_, raw.cloud) || params_.times == "azimuth") times_from_azimuth(raw.cloud);
    return true;
  }
  if ((!from_field && decided_) || raw.times.empty()) return true;
  const bool named_absolute = !from_field && raw.time_field == "timestamp";
  const double unit = from_field ? time_scale_ : named_absolute ? (raw.times.front() > 1e15 ? 1e-9 : 1.0) : named_unit(raw);
  const bool absolute = description_.time_origin == "absolute" || named_absolute;
  const bool own_clock = description_.time_origin == "on the sensor's own clock";
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
    const double offset = own_clock  ? unit * (value - (stamp_fraction_ == 0 ? low : high))
                          : absolute ? since(raw.cloud.stamp, value, unit)
                                     : unit * value;
    largest = std::max(largest, std::abs(offset));
    points[i].time = static_cast<float>(offset);
  }
  if (largest <= largest_offset) return true;
  error = "field " + raw.time_field + " puts points " + std::to_string(largest) + " s away from the cloud's stamp: another unit or clock";
  return false;
}

void SensorAdapter::times_from_azimuth(Cloud& cloud) const {
  struct Progress {
    double azimuth = 0, swept = 0;
    bool begun = false;
  };
  auto& points = cloud.points;
  const bool by_ring = ordered_by_ring(points);
  // Where the turn begins: at the first point; of clouds ordered by ring, at the earliest of the rings' first points.
  std::optional<double> begin;
  int ring = -1;
  for (const Point& p : points) {
    if (!valid(p)) continue;
    if (begin && (!by_ring || p.ring == ring)) continue;
    ring = p.ring;
    const double azimuth = azimuth_of(p);
    if (!begin || turn_sign_ * wrapped(azimuth - *begin) < 0) begin = azimuth;
  }
  if (!begin) return;
  std::vector<Progress> rows(1);
  std::vector<double> swept(points.size(), 0.0);
  double high = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    if (!valid(p)) continue;
    const std::size_t row = by_ring ? p.ring : 0;
    if (row >= rows.size()) rows.resize(row + 1);
    Progress& own = rows[row];
    const double azimuth = azimuth_of(p);
    double step = turn_sign_ * wrapped(azimuth - (own.begun ? own.azimuth : *begin));
    if (step < -M_PI / 2) step += full_turn;  // nothing returned for more than half a turn
    own.swept += step;
    own.azimuth = azimuth;
    own.begun = true;
    swept[i] = own.swept;
    high = std::max(high, own.swept);
  }
  const double origin = stamp_fraction_ * high;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (valid(points[i])) points[i].time = static_cast<float>((swept[i] - origin) / full_turn * description_.turn);
  }
}

void SensorAdapter::join(Cloud cloud, std::vector<CloudPtr>& scans) {
  RawScan slice;
  slice.cloud = std::move(cloud);
  slice.has_ring = true;
  const Look look = look_at(slice, std::nullopt);
  double length = look.swept != 0 ? std::abs(look.swept) : look.coverage;
  // What returned nothing between two slices has been swept too.
  if (!joined_.empty()) length += std::clamp(turn_sign_ * wrapped(look.begin - joined_end_), 0.0, 0.5 * M_PI);
  const double turn = description_.turn > 0 ? description_.turn : 0.1;
  const auto hand_out = [&] {
    if (!joined_.empty()) scans.push_back(std::make_shared<const Cloud>(std::move(joined_)));
    joined_ = Cloud();
    joined_sweep_ = 0;
  };
  if (!joined_.empty() && std::abs(slice.cloud.stamp - joined_.stamp) > turn) hand_out();  // slices are missing, or time has jumped
  // The turn bears the stamp of its newest slice.
  const double moved = joined_.empty() ? 0.0 : slice.cloud.stamp - joined_.stamp;
  for (Point& p : joined_.points) p.time -= static_cast<float>(moved);
  joined_.stamp = slice.cloud.stamp;
  joined_.frame = slice.cloud.frame;
  joined_.points.insert(joined_.points.end(), slice.cloud.points.begin(), slice.cloud.points.end());
  joined_sweep_ += length;
  joined_end_ = look.end;
  if (joined_sweep_ + 0.5 * length >= full_turn) hand_out();
}

}  // namespace sgraph
