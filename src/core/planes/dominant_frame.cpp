#include "sgraph_slam/core/planes/dominant_frame.hpp"

#include <algorithm>
#include <cmath>

namespace sgraph {
namespace {

constexpr double quarter = M_PI / 2;

// Wall near a direction, weighted with a triangle of half width `reach`, and the mean direction of it.
DominantFrame gather(const std::vector<WallDirection>& walls, double yaw, double reach) {
  double sum = 0;
  double moment = 0;
  for (const WallDirection& wall : walls) {
    const double off = wrap_quarter(wall.yaw - yaw);
    const double weight = wall.length * std::max(0.0, 1 - std::abs(off) / reach);
    sum += weight;
    moment += weight * off;
  }
  return {sum > 0 ? wrap_quarter(yaw + moment / sum) : yaw, sum};
}

DominantFrame settle(const std::vector<WallDirection>& walls, double yaw, double reach) {
  DominantFrame frame = gather(walls, yaw, reach);
  for (int i = 0; i < 5; ++i) frame = gather(walls, frame.yaw, reach);
  return frame;
}

}  // namespace

double wrap_quarter(double angle) {
  const double wrapped = angle - quarter * std::floor(angle / quarter + 0.5);
  return wrapped >= quarter / 2 ? wrapped - quarter : wrapped;
}

DominantFrame estimate_dominant_frame(const std::vector<WallDirection>& walls, const DominantFrame& present, const DominantFrameParams& params) {
  const double reach = 2 * params.bin;
  DominantFrame best;
  const int steps = std::max(8, static_cast<int>(std::ceil(quarter / params.bin)));
  for (int i = 0; i < steps; ++i) {
    const DominantFrame at = gather(walls, wrap_quarter(quarter * i / steps), reach);
    if (at.length > best.length) best = at;
  }
  best = settle(walls, best.yaw, reach);
  if (best.length < params.min_length) return present;
  if (!present.known()) return best;
  const DominantFrame kept = settle(walls, present.yaw, reach);
  const DominantFrame& next = best.length > params.switch_gain * kept.length ? best : kept;
  return {present.yaw + wrap_quarter(next.yaw - present.yaw), next.length};  // no step of 90 degrees where the range ends: it would swap x and y
}

PlaneClass classify(const Eigen::Vector3d& normal_map, const DominantFrame& frame, PlaneClass present, const PlaneClassParams& params) {
  const auto slack = [&](PlaneClass candidate) { return present == candidate ? params.hysteresis : 0.0; };
  const double elevation = std::asin(std::clamp(std::abs(normal_map.z()), 0.0, 1.0));  // of the normal above the horizon
  if (M_PI / 2 - elevation < params.tilt + slack(PlaneClass::horizontal)) return PlaneClass::horizontal;
  const bool was_wall = present == PlaneClass::x || present == PlaneClass::y;
  if (elevation > params.tilt + (was_wall ? params.hysteresis : 0.0)) return PlaneClass::unclassified;
  const double yaw = std::atan2(normal_map.y(), normal_map.x()) - frame.yaw;
  const double off = std::abs(wrap_quarter(yaw));
  const double turned = std::abs(std::remainder(yaw, M_PI));  // 0: along x, 90 degrees: along y
  const PlaneClass nearest = turned < M_PI / 4 ? PlaneClass::x : PlaneClass::y;
  if (off > params.oblique + slack(nearest)) return PlaneClass::unclassified;
  return nearest;
}

}  // namespace sgraph
