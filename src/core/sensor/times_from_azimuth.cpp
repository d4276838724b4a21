#include "times_from_azimuth.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "azimuth.hpp"

namespace sgraph {
namespace {

// Share of neighbours in the message that have the same ring.
bool ordered_by_ring(const std::vector<Point>& points) {
  std::size_t same = 0;
  for (std::size_t i = 1; i < points.size(); ++i) same += points[i].ring == points[i - 1].ring;
  return 2 * same > points.size();
}

}  // namespace

void times_from_azimuth(Cloud& cloud, double turn, double turn_sign, double stamp_fraction) {
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
    if (!is_return(p)) continue;
    if (begin && (!by_ring || p.ring == ring)) continue;
    ring = p.ring;
    const double azimuth = azimuth_of(p);
    if (!begin || turn_sign * wrapped(azimuth - *begin) < 0) begin = azimuth;
  }
  if (!begin) return;
  std::vector<Progress> rows(1);
  std::vector<double> swept(points.size(), 0.0);
  double high = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point& p = points[i];
    if (!is_return(p)) continue;
    const std::size_t row = by_ring ? p.ring : 0;
    if (row >= rows.size()) rows.resize(row + 1);
    Progress& own = rows[row];
    const double azimuth = azimuth_of(p);
    double step = turn_sign * wrapped(azimuth - (own.begun ? own.azimuth : *begin));
    if (step < -M_PI / 2) step += full_turn;  // nothing returned for more than half a turn
    own.swept += step;
    own.azimuth = azimuth;
    own.begun = true;
    swept[i] = own.swept;
    high = std::max(high, own.swept);
  }
  const double origin = stamp_fraction * high;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_return(points[i])) points[i].time = static_cast<float>((swept[i] - origin) / full_turn * turn);
  }
}

}  // namespace sgraph
