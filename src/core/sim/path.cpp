#include "path.hpp"

#include <algorithm>
#include <cmath>

namespace sgraph::sim {

namespace {

constexpr double step = 0.01;                        // along the path [m]
constexpr double turn_on_spot = 120.0 * M_PI / 180;  // sharper turns aren't driven as a curve

double wrap(double angle) { return std::remainder(angle, 2 * M_PI); }

double heading_of(const Eigen::Vector2d& v) { return std::atan2(v.y(), v.x()); }

struct PathPoint {
  Eigen::Vector2d position;
  double heading;
  double curvature;
  double curvature_rate;  // d curvature / d length
  double length;          // to the next point
  double z = 0;           // of the floor
};

// Curve of length 1 that turns by `angle` with the curvature angle (1 - cos 2 pi s): curvature and its first derivative vanish at both ends.
Eigen::Vector2d unit_curve(double angle, int pieces) {
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  const double h = 1.0 / pieces;
  for (int i = 0; i < pieces; ++i) {
    const double m = (i + 0.5) * h;
    const double heading = angle * (m - std::sin(2 * M_PI * m) / (2 * M_PI));
    end += h * Eigen::Vector2d(std::cos(heading), std::sin(heading));
  }
  return end;
}

class PathBuilder {
 public:
  std::vector<PathPoint> build(const std::vector<Waypoint>& waypoints, double corner_distance) {
    std::vector<Eigen::Vector2d> corners;
    for (const Waypoint& waypoint : waypoints) corners.push_back(waypoint.position);
    double begin = 0;  // already covered of the leg by the last curve
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
      const Eigen::Vector2d leg = corners[i + 1] - corners[i];
      const double length = leg.norm();
      const double heading = heading_of(leg);
      double angle = 0;
      double cut = 0;
      if (i + 2 < corners.size()) {
        const Eigen::Vector2d next = corners[i + 2] - corners[i + 1];
        angle = wrap(heading_of(next) - heading);
        cut = std::abs(angle) < 1e-6 ? 0 : std::min({corner_distance, 0.5 * length, 0.5 * next.norm()});
      }
      straight(corners[i] + begin * leg / length, heading, length - begin - cut);
      if (cut > 0) curve(corners[i + 1] - cut * leg / length, heading, angle, cut);
      begin = cut;
    }
    points_.push_back({corners.back(), heading_of(corners.back() - corners[corners.size() - 2]), 0, 0, 0});
    set_heights(waypoints);
    return points_;
  }

 private:
  void straight(const Eigen::Vector2d& from, double heading, double length) {
    const int pieces = std::max(1, static_cast<int>(std::ceil(length / step)));
    const Eigen::Vector2d direction(std::cos(heading), std::sin(heading));
    if (length < 1e-9) return;
    for (int i = 0; i < pieces; ++i) points_.push_back({from + direction * (length * i / pieces), heading, 0, 0, length / pieces});
  }

  void curve(const Eigen::Vector2d& from, double heading, double angle, double cut) {
    const Eigen::Vector2d chord = unit_curve(angle, 400);
    const double length = cut * std::abs(std::sin(angle) / chord.y());
    const int pieces = std::max(20, static_cast<int>(std::ceil(length / step)));
    const Eigen::Rotation2Dd turn(heading);
    Eigen::Vector2d position = from;
    for (int i = 0; i < pieces; ++i) {
      const double s = static_cast<double>(i) / pieces;
      const double h = length / pieces;
      const double theta = heading + angle * (s - std::sin(2 * M_PI * s) / (2 * M_PI));
      points_.push_back(
          {position, theta, angle / length * (1 - std::cos(2 * M_PI * s)), angle / (length * length) * 2 * M_PI * std::sin(2 * M_PI * s), h});
      const double middle = s + 0.5 / pieces;
      const double theta_middle = heading + angle * (middle - std::sin(2 * M_PI * middle) / (2 * M_PI));
      position += h * Eigen::Vector2d(std::cos(theta_middle), std::sin(theta_middle));
    }
  }

  // Heights of the floor along the path: even between the waypoints. A point belongs to the leg on which it falls, and legs are passed in order; in a
  // curve the leg changes where the next waypoint's bisector is crossed.
  void set_heights(const std::vector<Waypoint>& waypoints) {
    std::size_t leg = 0;
    for (PathPoint& point : points_) {
      while (leg + 2 < waypoints.size()) {
        const Eigen::Vector2d in = (waypoints[leg + 1].position - waypoints[leg].position).normalized();
        const Eigen::Vector2d out = (waypoints[leg + 2].position - waypoints[leg + 1].position).normalized();
        if ((point.position - waypoints[leg + 1].position).dot(in + out) < 0) break;
        ++leg;
      }
      const Eigen::Vector2d way = waypoints[leg + 1].position - waypoints[leg].position;
      const double share = std::min(1.0, std::max(0.0, (point.position - waypoints[leg].position).dot(way) / way.squaredNorm()));
      point.z = waypoints[leg].z + share * (waypoints[leg + 1].z - waypoints[leg].z);
    }
  }

  std::vector<PathPoint> points_;
};

// Appends states in time; keeps the heading unwrapped.
class Driver {
 public:
  Driver(const Waypoint& start, double heading, const MotionProfile& profile) : profile_(profile) {
    states_.push_back({0, start.position, heading, start.z});
  }

  void stand(double seconds) {
    PlanarState state = states_.back();
    state.time += seconds;
    if (seconds > 0) states_.push_back(state);
  }

  // Carried by a lift: the doors shut, it goes, the doors open.
  void ride(double z) {
    constexpr double doors = 3.0;         // [s]
    constexpr double speed = 1.0;         // [m/s]
    constexpr double acceleration = 0.7;  // [m/s^2]
    stand(doors);
    const PlanarState start = states_.back();
    const double way = std::abs(z - start.z);
    const double ramp = std::min(speed / acceleration, std::sqrt(way / acceleration));
    const double cruise = way / (acceleration * ramp) - ramp;
    const double total = 2 * ramp + cruise;
    const int pieces = static_cast<int>(std::ceil(total / 0.01));
    for (int i = 1; i <= pieces; ++i) {
      const double t = total * i / pieces;
      double gone = way - 0.5 * acceleration * (total - t) * (total - t);
      if (t < ramp) {
        gone = 0.5 * acceleration * t * t;
      } else if (t < ramp + cruise) {
        gone = acceleration * ramp * (t - 0.5 * ramp);
      }
      states_.push_back({start.time + t, start.position, start.heading, start.z + std::copysign(gone, z - start.z)});
    }
    states_.back().z = z;
    stand(doors);
  }

  void turn_to(double heading) {
    const PlanarState start = states_.back();
    const double angle = wrap(heading - start.heading);
    const double alpha = profile_.turn_acceleration;
    const double ramp = std::min(profile_.turn_rate / alpha, std::sqrt(std::abs(angle) / alpha));
    if (std::abs(angle) < 1e-9) return;
    const double cruise = std::abs(angle) / (alpha * ramp) - ramp;
    const double total = 2 * ramp + cruise;
    const int pieces = std::max(2, static_cast<int>(std::ceil(total / 0.01)));
    for (int i = 1; i <= pieces; ++i) {
      const double t = total * i / pieces;
      double turned = 0;
      if (t < ramp) {
        turned = 0.5 * alpha * t * t;
      } else if (t < ramp + cruise) {
        turned = alpha * ramp * (t - 0.5 * ramp);
      } else {
        turned = std::abs(angle) - 0.5 * alpha * (total - t) * (total - t);
      }
      states_.push_back({start.time + t, start.position, start.heading + std::copysign(turned, angle), start.z});
    }
  }

  void drive(const std::vector<PathPoint>& path) {
    const std::vector<double> speed = speeds(path);
    const double turns = states_.back().heading - path.front().heading;
    const double offset = 2 * M_PI * std::round(turns / (2 * M_PI));
    double last = path.front().heading;
    double unwrapped = last + offset;
    double time = states_.back().time;
    for (std::size_t i = 1; i < path.size(); ++i) {
      const PathPoint& from = path[i - 1];
      const double seconds = 2 * from.length / (speed[i - 1] + speed[i]);
      const double turn = wrap(path[i].heading - last);
      const int pieces = std::max(1, static_cast<int>(std::ceil(seconds / 0.01)));
      for (int k = 1; k <= pieces; ++k) {  // with constant acceleration, as near a stop one step takes long
        const double t = seconds * k / pieces;
        const double f = (speed[i - 1] + 0.5 * (speed[i] - speed[i - 1]) * t / seconds) * t / from.length;
        states_.push_back(
            {time + t, from.position + f * (path[i].position - from.position), unwrapped + f * turn, from.z + f * (path[i].z - from.z)});
      }
      time += seconds;
      unwrapped += turn;
      last = path[i].heading;
    }
  }

  [[nodiscard]] std::vector<PlanarState> states() const { return states_; }

 private:
  [[nodiscard]] std::vector<double> speeds(const std::vector<PathPoint>& path) const {
    std::vector<double> speed(path.size());
    for (std::size_t i = 0; i < path.size(); ++i) {
      const double k = std::max(std::abs(path[i].curvature), 1e-9);
      const double rate = std::max(std::abs(path[i].curvature_rate), 1e-9);
      speed[i] = std::min({profile_.speed, profile_.turn_rate / k, std::sqrt(profile_.turn_acceleration / rate)});
    }
    speed.front() = speed.back() = 0;
    for (std::size_t i = 1; i < path.size(); ++i) {
      speed[i] = std::min(speed[i], std::sqrt(speed[i - 1] * speed[i - 1] + 2 * profile_.acceleration * path[i - 1].length));
    }
    for (std::size_t i = path.size() - 1; i-- > 0;) {
      speed[i] = std::min(speed[i], std::sqrt(speed[i + 1] * speed[i + 1] + 2 * profile_.acceleration * path[i].length));
    }
    return speed;
  }

  MotionProfile profile_;
  std::vector<PlanarState> states_;
};

bool stops_at(const std::vector<Waypoint>& waypoints, std::size_t i) {
  if (i + 1 >= waypoints.size() || waypoints[i].wait > 0 || waypoints[i].carried_to) return true;
  const double in = heading_of(waypoints[i].position - waypoints[i - 1].position);
  const double out = heading_of(waypoints[i + 1].position - waypoints[i].position);
  return std::abs(wrap(out - in)) > turn_on_spot;
}

}  // namespace

std::vector<PlanarState> drive_route(const Route& route, const MotionProfile& profile) {
  const std::vector<Waypoint>& waypoints = route.waypoints;
  if (waypoints.empty()) throw WorldError("the route has no waypoint");
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    if ((waypoints[i].position - waypoints[i - 1].position).norm() < 0.05) throw WorldError("two waypoints in a row are at the same place");
  }
  Driver driver(waypoints.front(), route.start_heading, profile);
  driver.stand(route.stand);
  std::vector<Waypoint> leg{waypoints.front()};
  for (std::size_t i = 1; i < waypoints.size(); ++i) {
    leg.push_back(waypoints[i]);
    if (!stops_at(waypoints, i)) continue;
    driver.turn_to(heading_of(leg[1].position - leg[0].position));
    driver.drive(PathBuilder().build(leg, profile.corner));
    driver.stand(waypoints[i].wait);
    leg = {waypoints[i]};
    if (!waypoints[i].carried_to) continue;
    driver.ride(*waypoints[i].carried_to);
    leg.front().z = *waypoints[i].carried_to;
  }
  driver.stand(route.stand_end);
  return driver.states();
}

}  // namespace sgraph::sim
