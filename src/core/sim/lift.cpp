#include "lift.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sgraph::sim {

namespace {

constexpr double step = 0.01;             // between moments at which cabin and doors are looked at anew [s]
constexpr double shut_for = 0.5;          // the doors are shut this long before and after the cabin moves [s]
constexpr double door_time = 2.0;         // that they take to open or to shut [s]
constexpr double look_every = 0.1;        // for a ride that is to come or has been [s]
constexpr double moves = 0.01;            // [m/s] up or down
constexpr double near = 3.5;              // [m] from the cabin's middle, where doors begin to shut
constexpr double to_landing_door = 0.12;  // from the cabin's door to the landing's [m]
constexpr double no_hit = std::numeric_limits<double>::infinity();

}  // namespace

LiftTrack::LiftTrack(const World& world, std::size_t lift, const std::function<Pose(double)>& motion)
    : lift_(world.lifts.at(lift)), base_height_(world.motion.base_height), motion_(motion) {}

bool LiftTrack::rides_at(double time) const {
  constexpr double h = 0.02;
  const Eigen::Vector3d before = motion_(time - h).translation;
  const Eigen::Vector3d after = motion_(time + h).translation;
  const Eigen::Vector2d p = 0.5 * (before + after).head<2>();
  const bool inside = (p - lift_.low).minCoeff() > 0 && (lift_.high - p).minCoeff() > 0;
  return inside && (after - before).head<2>().norm() < 1e-4 && std::abs(after.z() - before.z()) > 2 * h * moves;
}

void LiftTrack::move_to(double time) {
  const double moment = step * std::floor(time / step);
  if (moment == time_) return;
  time_ = moment;
  const Eigen::Vector3d robot = motion_(moment).translation;
  const double stands_on = robot.z() - base_height_;
  floor_ = lift_.floors.front();
  for (const double z : lift_.floors) {
    if (std::abs(z - stands_on) < std::abs(floor_ - stands_on)) floor_ = z;
  }
  double since_ride = door_time + shut_for;
  for (double d = 0; d < since_ride; d += look_every) {
    if (rides_at(moment + d) || rides_at(moment - d)) since_ride = d;
  }
  if (since_ride == 0) floor_ = stands_on;
  const double distance = (robot.head<2>() - 0.5 * (lift_.low + lift_.high)).norm();
  open_ = std::clamp(std::min((since_ride - shut_for) / door_time, 1 + near - distance), 0.0, 1.0);

  rectangles_.clear();
  const double top = floor_ + lift_.height;
  rectangles_.push_back(Rectangle{2, floor_, lift_.low, lift_.high});
  rectangles_.push_back(Rectangle{2, top, lift_.low, lift_.high});
  for (int axis = 0; axis < 2; ++axis) {
    const int other = 1 - axis;
    for (const bool high : {false, true}) {
      const double at = high ? lift_.high[axis] : lift_.low[axis];
      if (std::abs(at - lift_.door[axis]) < 0.01) {
        add_doorway(at, floor_, open_, true, top);
        const double outside = at + (high ? to_landing_door : -to_landing_door);
        for (const double z : lift_.floors) add_doorway(outside, z, z == floor_ ? open_ : 0.0, false, z + lift_.door_height);
      } else if (axis == 0) {
        rectangles_.push_back(Rectangle{0, at, {lift_.low[other], floor_}, {lift_.high[other], top}});  // along y, z
      } else {
        rectangles_.push_back(Rectangle{1, at, {floor_, lift_.low[other]}, {top, lift_.high[other]}});  // along z, x
      }
    }
  }
}

// The side of the cabin with its door, or the leaf on a landing alone.
void LiftTrack::add_doorway(double plane, double bottom, double open, bool frame, double top) {
  const int axis = std::abs(lift_.low.x() - lift_.door.x()) < 0.01 || std::abs(lift_.high.x() - lift_.door.x()) < 0.01 ? 0 : 1;
  const int other = 1 - axis;
  const double left = lift_.door[other] - 0.5 * lift_.door_width;
  const double right = left + lift_.door_width;
  const double lintel = bottom + lift_.door_height;
  const auto add = [&](double begin, double end, double from, double to) {
    if (end - begin < 1e-6 || to - from < 1e-6) return;
    if (axis == 0) {
      rectangles_.push_back(Rectangle{0, plane, {begin, from}, {end, to}});
    } else {
      rectangles_.push_back(Rectangle{1, plane, {from, begin}, {to, end}});
    }
  };
  add(left, right - open * lift_.door_width, bottom, lintel);
  if (!frame) return;
  add(lift_.low[other], left, bottom, top);
  add(right, lift_.high[other], bottom, top);
  add(left, right, lintel, top);
}

LiftHit LiftTrack::cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  LiftHit hit{no_hit, 0, Eigen::Vector3d::Zero()};
  for (const Rectangle& r : rectangles_) {
    if (std::abs(direction[r.axis]) < 1e-9) continue;
    const double distance = (r.at - origin[r.axis]) / direction[r.axis];
    if (distance < 1e-3 || distance >= hit.distance) continue;
    const int u = (r.axis + 1) % 3;
    const int v = (r.axis + 2) % 3;
    const Eigen::Vector2d p(origin[u] + distance * direction[u], origin[v] + distance * direction[v]);
    if ((p - r.low).minCoeff() < 0 || (r.high - p).minCoeff() < 0) continue;
    hit = {distance, std::abs(direction[r.axis]), Eigen::Vector3d::Unit(r.axis)};
  }
  return hit;
}

}  // namespace sgraph::sim
