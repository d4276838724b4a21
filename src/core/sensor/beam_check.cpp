#include "beam_check.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "azimuth.hpp"
#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {
namespace {

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

}  // namespace

bool lies_on_cones(const RingTable& table, const Cloud& cloud) {
  std::vector<double> away;
  const std::size_t stride = std::max<std::size_t>(1, cloud.size() / 400);
  for (std::size_t i = 0; i < cloud.size(); i += stride) {
    if (is_return(cloud.points[i])) away.push_back(distance_to_cone(table, cloud.points[i]));
  }
  return !away.empty() && upper_median(away) < 0.003;  // [m] drivers round to millimetres; a turn's motion is centimetres
}

bool lies_on_beams(const RingTable& table, bool by_field, const Cloud& cloud) {
  const double span = std::atan(table.cones.back().slope) - std::atan(table.cones.front().slope);
  const double allowed = std::max(0.5 * span / std::max(1, table.rows() - 1), 0.02);  // [rad] half the spacing, or a degree
  std::vector<double> errors;
  const std::size_t stride = std::max<std::size_t>(1, cloud.size() / 400);
  std::size_t looked_at = 0;
  for (std::size_t i = 0; i < cloud.size(); i += stride) {
    const Point& p = cloud.points[i];
    ++looked_at;
    if (!is_return(p) || std::hypot(static_cast<double>(p.x), static_cast<double>(p.y)) < 0.5) continue;
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

}  // namespace sgraph
