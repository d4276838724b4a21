#include "sgraph_slam/core/odometry/ride_detector.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

namespace sgraph {
namespace {

constexpr double cabin_reach = 3.0;      // [m] from the sensor to the farthest corner of a lift's cabin, on the ground; a bed lift is 1.8 x 2.7 m
constexpr double near_share = 0.4;       // of a scan's points that are nearer while the doors are open,
constexpr double one_side = 0.9;         // and how much the others lie in one direction: length of the mean of their directions
constexpr double straight = 0.15;        // [m] that a wall is nearer than the farthest point within five degrees,
constexpr double on_walls = 0.9;         // and share of the near points on walls
constexpr double most_beyond = 0.005;    // of a scan's points that may lie beyond while the doors are shut: the slit, noise
constexpr double all_round = 2.0 / 3;    // of the directions show the cabin; the sensor is blind for a wall that is too near
constexpr double moved_on = 0.4;         // [m] after which the cabin is looked at anew
constexpr int shortest_ride = 20;        // scans: one floor takes five seconds and more
constexpr double beyond = 0.3;           // [m] behind the cabin's walls; the landing's door is nearer
constexpr double band_low = -0.3;        // [m] below the sensor and
constexpr double band_high = 0.8;        // above it: floors and ceilings look alike wherever the doors open
constexpr double same_range = 0.2;       // [m]
constexpr int enough = 300;              // points that are compared,
constexpr int fewest = 50;               // and when the robot leaves the cabin
constexpr double same_floor = 0.5;       // of them known
constexpr double lowest = -24, row = 2;  // [deg] rows begin here, and are so high

int sector_of(const Eigen::Vector3d& level, int sectors) {
  const double turn = std::atan2(level.y(), level.x()) / (2 * M_PI);
  return std::min(static_cast<int>((turn - std::floor(turn)) * sectors), sectors - 1);
}

}  // namespace

bool like_a_cabin(const Cloud& cloud, const Pose& T_odom_lidar, const Eigen::Vector3d& up) {
  constexpr std::size_t sectors = 72;
  const Eigen::Matrix3d rotation = T_odom_lidar.matrix();
  const double all = static_cast<double>(cloud.size());
  double outside = 0;
  Eigen::Vector3d directions = Eigen::Vector3d::Zero();
  for (const Point& point : cloud.points) {
    const Eigen::Vector3d ray = rotation * point.position().cast<double>();
    const Eigen::Vector3d level = ray - up.dot(ray) * up;
    const double range2 = level.squaredNorm();
    if (range2 <= cabin_reach * cabin_reach) continue;
    if (++outside > (1 - near_share) * all) return false;  // nearly every scan of a building
    directions += level / std::sqrt(range2);
  }
  if (outside > most_beyond * all && directions.norm() < one_side * outside) return false;
  // On stairs what is near recedes from step to step.
  std::array<double, sectors> farthest{};
  std::vector<std::pair<std::size_t, double>> near;
  for (const Point& point : cloud.points) {
    const Eigen::Vector3d ray = rotation * point.position().cast<double>();
    const Eigen::Vector3d level = ray - up.dot(ray) * up;
    const double range = level.norm();
    if (range > cabin_reach) continue;
    near.emplace_back(static_cast<std::size_t>(sector_of(level, sectors)), range);
    farthest[near.back().first] = std::max(farthest[near.back().first], range);
  }
  const auto on_wall = std::count_if(near.begin(), near.end(), [&](const auto& seen) { return seen.second > farthest[seen.first] - straight; });
  return static_cast<double>(on_wall) > on_walls * static_cast<double>(near.size());
}

RideDetector::Bearing RideDetector::bearing(const Eigen::Vector3d& in_odom) const {
  const Eigen::Vector3d from_here = in_odom - position_;
  const double height = up_.dot(from_here);
  const Eigen::Vector3d level = from_here - height * up_;
  const double range = level.norm();
  const double elevation = std::atan2(height, range) * 180 / M_PI;
  return {sector_of(level, sectors), sector_of(level, columns), std::clamp(static_cast<int>((elevation - lowest) / row), 0, rows - 1), range, height};
}

double RideDetector::wall(int sector) const {
  const auto of = [this](int s) { return walls_[static_cast<std::size_t>((s + sectors) % sectors)]; };
  return std::max({of(sector - 1), of(sector), of(sector + 1)});
}

bool RideDetector::beyond_walls(const Bearing& b) const { return b.range > wall(b.sector) + beyond; }

bool RideDetector::shut() const { return shut_for_ >= shortest_ride; }

RideDetector::Seen RideDetector::see(const Cloud& deskewed, const Pose& T_odom_lidar, const Eigen::Vector3d& up) {
  up_ = up;
  if (!shut()) {
    const bool was_inside = inside_;
    inside_ = like_a_cabin(deskewed, T_odom_lidar, up_);
    if (!inside_) return Seen::nothing;
    if (!was_inside || (T_odom_lidar.translation - position_).norm() > moved_on) enter(T_odom_lidar.translation);
    tighten(deskewed, T_odom_lidar);
    remember(deskewed, T_odom_lidar);
    shut_for_ = shows_cabin_alone(deskewed, T_odom_lidar) ? shut_for_ + 1 : 0;
    return Seen::nothing;
  }
  if (shows_cabin_alone(deskewed, T_odom_lidar)) {
    tighten(deskewed, T_odom_lidar);  // before a narrow corridor the open doors may have passed for shut ones
    known_ = unknown_ = 0;
    return Seen::nothing;
  }
  look_beyond(deskewed, T_odom_lidar);
  const Bearing sensor = bearing(T_odom_lidar.translation);
  const bool has_left = sensor.range > wall(sensor.sector);
  if (known_ + unknown_ < enough && !has_left) return Seen::nothing;
  inside_ = false;
  shut_for_ = 0;
  if (known_ + unknown_ < fewest) return Seen::another_door;
  return known_ < same_floor * (known_ + unknown_) ? Seen::another_floor : Seen::same_floor;
}

void RideDetector::enter(const Eigen::Vector3d& position) {
  position_ = position;
  shut_for_ = known_ = unknown_ = 0;
  walls_ = {};
  before_ = {};
}

void RideDetector::tighten(const Cloud& deskewed, const Pose& T_odom_lidar) {
  std::array<double, sectors> farthest{};
  for (const Point& point : deskewed.points) {
    const Bearing b = bearing(T_odom_lidar * point.position().cast<double>());
    double& far = farthest[static_cast<std::size_t>(b.sector)];
    far = std::max(far, b.range);
  }
  for (std::size_t i = 0; i < sectors; ++i) {
    if (farthest[i] > 0) walls_[i] = walls_[i] > 0 ? std::min(walls_[i], farthest[i]) : farthest[i];
  }
}

void RideDetector::remember(const Cloud& deskewed, const Pose& T_odom_lidar) {
  for (const Point& point : deskewed.points) {
    const Bearing b = bearing(T_odom_lidar * point.position().cast<double>());
    if (b.height < band_low || b.height > band_high) continue;
    double& seen = before_[static_cast<std::size_t>(b.column)][static_cast<std::size_t>(b.row)];
    seen = std::max(seen, b.range);
  }
}

bool RideDetector::shows_cabin_alone(const Cloud& deskewed, const Pose& T_odom_lidar) const {
  const auto seen = std::count_if(walls_.begin(), walls_.end(), [](double range) { return range > 0; });
  if (static_cast<double>(seen) < all_round * sectors || *std::max_element(walls_.begin(), walls_.end()) > cabin_reach) return false;
  const auto outside = std::count_if(deskewed.points.begin(), deskewed.points.end(),
                                     [&](const Point& point) { return beyond_walls(bearing(T_odom_lidar * point.position().cast<double>())); });
  return static_cast<double>(outside) <= most_beyond * static_cast<double>(deskewed.size());
}

void RideDetector::look_beyond(const Cloud& deskewed, const Pose& T_odom_lidar) {
  for (const Point& point : deskewed.points) {
    const Bearing b = bearing(T_odom_lidar * point.position().cast<double>());
    if (b.height < band_low || b.height > band_high || !beyond_walls(b)) continue;
    double nearest = HUGE_VAL;
    double farthest = 0;
    for (int c = b.column - 1; c <= b.column + 1; ++c) {
      for (int r = std::max(0, b.row - 1); r <= std::min(rows - 1, b.row + 1); ++r) {
        const double range = before_[static_cast<std::size_t>((c + columns) % columns)][static_cast<std::size_t>(r)];
        if (range < wall(b.sector) + beyond) continue;
        nearest = std::min(nearest, range);
        farthest = std::max(farthest, range);
      }
    }
    if (farthest == 0) continue;
    ++(b.range > nearest - same_range && b.range < farthest + same_range ? known_ : unknown_);
  }
}

CloudPtr RideDetector::within_cabin(const Cloud& deskewed, const Pose& T_odom_lidar) const {
  auto inside = std::make_shared<Cloud>(deskewed);
  inside->points.erase(std::remove_if(inside->points.begin(), inside->points.end(),
                                      [&](const Point& point) { return beyond_walls(bearing(T_odom_lidar * point.position().cast<double>())); }),
                       inside->points.end());
  return inside;
}

}  // namespace sgraph
