#include "sgraph_slam/core/sim/lidar.hpp"

#include <algorithm>
#include <cmath>

#include "people.hpp"
#include "sgraph_slam/core/util/rng.hpp"
#include "streams.hpp"

namespace sgraph::sim {

namespace vlp16 {

double elevation(int ring) { return (-15.0 + 2.0 * ring) * M_PI / 180; }

std::int64_t first_firing(int scan, double rate) { return static_cast<std::int64_t>(std::ceil(scan / (rate * firing_interval) - 1e-9)); }

}  // namespace vlp16

namespace {

constexpr int azimuth_steps = 36000;
constexpr int most_panes = 4;  // that one ray passes

double reflectivity(Material material) {
  switch (material) {
    case Material::plaster: return 0.60;
    case Material::concrete: return 0.35;
    case Material::wood: return 0.45;
    case Material::fabric: return 0.25;
    case Material::metal: return 0.40;
    case Material::glass: return 0.10;
    case Material::ground: return 0.20;
  }
  return 0;
}

// Share of the light that a pane lets through, both ways; less at grazing incidence (Fresnel).
double through_pane(double cosine) {
  const double reflected = 0.08 + 0.92 * std::pow(1 - cosine, 5);
  return (1 - reflected) * (1 - reflected);
}

// An echo, before noise.
struct Echo {
  double distance = 0;
  double cosine = 0;
  double reflectivity = 0;
  double strength = 1;  // left of the light after the panes that it passed
};

// The probability that the sensor reports an echo. 80 % reflectivity is seen at 100 m (data sheet); a pulse that strikes at a grazing angle is
// smeared out, and lost below about two degrees; one return in 500 is missing anyway.
double detection_probability(const Echo& echo) {
  const double range = std::max(echo.distance, 1.0);
  const double power = echo.reflectivity * echo.strength * echo.cosine / 0.8 * (100.0 / range) * (100.0 / range);
  const double seen = power / (power + 0.5);
  const double graze = echo.cosine / 0.035;
  return 0.998 * seen * (1 - std::exp(-graze * graze));
}

struct Frame {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d origin;
};

}  // namespace

class Lidar::Implementation {
 public:
  Implementation(const World& world, PoseFunction motion, const LidarSettings& settings)
      : motion_(std::move(motion)),
        T_base_lidar_(world.T_base_lidar),
        settings_(settings),
        scene_(surfaces_of(world)),
        people_(world.people.begin(), world.people.end()),
        range_noise_(settings.seed, static_cast<std::uint64_t>(Stream::range)),
        detection_(settings.seed, static_cast<std::uint64_t>(Stream::detection)),
        glass_(settings.seed, static_cast<std::uint64_t>(Stream::glass)),
        intensity_noise_(settings.seed, static_cast<std::uint64_t>(Stream::intensity)) {
    for (int i = 0; i < azimuth_steps; ++i) circle_.emplace_back(std::cos(2 * M_PI * i / azimuth_steps), std::sin(2 * M_PI * i / azimuth_steps));
    for (int ring = 0; ring < vlp16::lasers; ++ring) elevation_.emplace_back(std::cos(vlp16::elevation(ring)), std::sin(vlp16::elevation(ring)));
  }

  Cloud scan(int number, double stamp_time) const {
    Cloud cloud;
    const std::int64_t first = vlp16::first_firing(number, settings_.rate);
    const std::int64_t last = vlp16::first_firing(number + 1, settings_.rate);
    cloud.points.reserve(static_cast<std::size_t>(last - first) * vlp16::lasers);
    Frame begin = frame_at(settings_.motion_distortion ? static_cast<double>(first) * vlp16::firing_interval : stamp_time);
    for (std::int64_t firing = first; firing < last; ++firing) {
      const Frame end = settings_.motion_distortion ? frame_at(static_cast<double>(firing + 1) * vlp16::firing_interval) : begin;
      fire(firing, begin, end, stamp_time, cloud.points);
      begin = end;
    }
    return cloud;
  }

 private:
  [[nodiscard]] Frame frame_at(double time) const {
    const Pose pose = motion_(time) * T_base_lidar_;
    return {pose.matrix(), pose.translation};
  }

  void fire(std::int64_t firing, const Frame& begin, const Frame& end, double stamp_time, std::vector<Point>& points) const {
    const double time = static_cast<double>(firing) * vlp16::firing_interval;
    RayPacket rays;
    for (std::size_t n = 0; n < vlp16::lasers; ++n) {
      const double offset = static_cast<double>(n) * vlp16::laser_interval;
      const double f = offset / vlp16::firing_interval;
      const double turned = (time + offset) * settings_.rate;
      const double azimuth = -2 * M_PI * (turned - std::floor(turned));
      const Eigen::Vector2d& e = elevation_[static_cast<std::size_t>(vlp16::ring_of_laser[n])];
      const Eigen::Vector3d direction(e.x() * std::cos(azimuth), e.x() * std::sin(azimuth), e.y());
      rays.direction[n] = ((1 - f) * (begin.rotation * direction) + f * (end.rotation * direction)).normalized();
      rays.origin[n] = (1 - f) * begin.origin + f * end.origin;
      rays.active[n] = true;
    }
    std::array<Echo, packet_size> echoes;
    trace(rays, firing, echoes);
    for (std::size_t n = 0; n < vlp16::lasers; ++n) report(firing, n, echoes[n], stamp_time, points);
  }

  // Follows the rays through panes to the surface that returns them; distance 0 when none does.
  void trace(RayPacket& rays, std::int64_t firing, std::array<Echo, packet_size>& echoes) const {
    const std::array<Echo, packet_size> people = trace_people(rays, firing);
    std::array<double, packet_size> strength;
    strength.fill(1.0);
    for (int pane = 0; pane <= most_panes; ++pane) {
      const HitPacket hits = scene_.cast(rays);
      bool more = false;
      for (std::size_t n = 0; n < packet_size; ++n) {
        if (!rays.active[n]) continue;
        rays.active[n] = false;
        if (people[n].distance > 0 && people[n].distance < hits.distance[n]) {
          echoes[n] = people[n];
          echoes[n].strength = strength[n];
        } else if (hits.surface[n] == nullptr) {
          continue;
        } else if (hits.surface[n]->material == Material::glass &&
                   !returned_by_glass(hits.cosine[n], ray_index(firing, n) * (most_panes + 1) + static_cast<std::uint64_t>(pane))) {
          strength[n] *= through_pane(hits.cosine[n]);
          rays.begin[n] = hits.distance[n] + 1e-3;
          rays.active[n] = more = true;
        } else {
          echoes[n] = {hits.distance[n], hits.cosine[n], reflectivity(hits.surface[n]->material), strength[n]};
        }
      }
      if (!more) break;
    }
  }

  // A pane mirrors: only within about eight degrees of the normal does enough come back.
  [[nodiscard]] bool returned_by_glass(double cosine, std::uint64_t index) const {
    const double angle = std::acos(std::min(1.0, cosine));
    return glass_.uniform(index) < 0.9 * std::exp(-angle * angle / (2 * 0.14 * 0.14));
  }

  [[nodiscard]] std::array<Echo, packet_size> trace_people(const RayPacket& rays, std::int64_t firing) const {
    std::array<Echo, packet_size> echoes;
    for (const PersonTrack& track : people_) {
      const PersonState state = track.at(static_cast<double>(firing) * vlp16::firing_interval);
      const Eigen::Vector2d to = state.position - rays.origin[0].head<2>();
      const Eigen::Vector2d ahead = rays.direction[0].head<2>().normalized();
      if (to.dot(ahead) < -0.6 || std::abs(to.x() * ahead.y() - to.y() * ahead.x()) > 0.6 + 0.02 * to.norm()) continue;
      for (std::size_t n = 0; n < packet_size; ++n) {
        double cosine = 0;
        const double distance = distance_to_person(track.person(), state, rays.origin[n], rays.direction[n], cosine);
        if (std::isfinite(distance) && (echoes[n].distance == 0 || distance < echoes[n].distance))
          echoes[n] = {distance, cosine, reflectivity(Material::fabric), 1};
      }
    }
    return echoes;
  }

  static std::uint64_t ray_index(std::int64_t firing, std::size_t laser) { return static_cast<std::uint64_t>(firing) * vlp16::lasers + laser; }

  void report(std::int64_t firing, std::size_t laser, const Echo& echo, double stamp_time, std::vector<Point>& points) const {
    if (echo.distance <= 0) return;
    const std::uint64_t index = ray_index(firing, laser);
    if (detection_.uniform(index) > detection_probability(echo)) return;
    const double noisy = settings_.range_noise > 0 ? echo.distance + settings_.range_noise * range_noise_.normal(index) : echo.distance;
    const double range = std::round(noisy / vlp16::range_step) * vlp16::range_step;
    if (range < settings_.min_range || range > settings_.max_range) return;

    const double time = static_cast<double>(firing) * vlp16::firing_interval + static_cast<double>(laser) * vlp16::laser_interval;
    const double turned = time * settings_.rate;
    const auto step = static_cast<std::size_t>(std::lround((turned - std::floor(turned)) * azimuth_steps)) % azimuth_steps;
    const int ring = vlp16::ring_of_laser[laser];
    const Eigen::Vector2d& e = elevation_[static_cast<std::size_t>(ring)];
    Point point;
    point.x = static_cast<float>(range * e.x() * circle_[step].x());
    point.y = static_cast<float>(-range * e.x() * circle_[step].y());
    point.z = static_cast<float>(range * e.y());
    const double bright = 100 * echo.reflectivity * (0.4 + 0.6 * echo.cosine) * echo.strength + 2 * intensity_noise_.normal(index);
    point.intensity = static_cast<float>(std::round(std::min(255.0, std::max(0.0, bright))));
    point.time = settings_.motion_distortion ? static_cast<float>(time - stamp_time) : 0.0F;
    point.ring = static_cast<std::uint16_t>(ring);
    points.push_back(point);
  }

  PoseFunction motion_;
  Pose T_base_lidar_;
  LidarSettings settings_;
  Scene scene_;
  std::vector<PersonTrack> people_;
  RandomStream range_noise_;
  RandomStream detection_;
  RandomStream glass_;
  RandomStream intensity_noise_;
  std::vector<Eigen::Vector2d> circle_;     // cosine, sine of each reported azimuth
  std::vector<Eigen::Vector2d> elevation_;  // cosine, sine by ring
};

Lidar::Lidar(const World& world, PoseFunction motion, const LidarSettings& settings)
    : settings_(settings), implementation_(std::make_unique<Implementation>(world, std::move(motion), settings)) {}
Lidar::~Lidar() = default;

Cloud Lidar::scan(int number) const {
  Cloud cloud = implementation_->scan(number, time_of(number));
  cloud.stamp = stamp_of(number);
  cloud.frame = settings_.frame;
  return cloud;
}

double Lidar::end_of(int number) const {
  return static_cast<double>(vlp16::first_firing(number + 1, settings_.rate) - 1) * vlp16::firing_interval +
         (vlp16::lasers - 1) * vlp16::laser_interval;
}

double Lidar::time_of(int number) const {
  const double time = settings_.stamp == StampConvention::last
                          ? end_of(number)
                          : static_cast<double>(vlp16::first_firing(number, settings_.rate)) * vlp16::firing_interval;
  return std::round(time * 1e9) * 1e-9;  // as the stamp holds it
}

Stamp Lidar::stamp_of(int number) const { return {settings_.start + std::llround(time_of(number) * 1e9)}; }

}  // namespace sgraph::sim
