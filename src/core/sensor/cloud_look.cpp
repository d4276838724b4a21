#include "sgraph_slam/core/sensor/cloud_look.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "azimuth.hpp"
#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {

CloudLook look_at(const RawScan& raw, const std::optional<RingTable>& table) {
  CloudLook look;
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
    if (!is_return(p)) continue;
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
  return look;
}

}  // namespace sgraph
