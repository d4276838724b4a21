#include "sgraph_slam/core/sim/lidar.hpp"

#include <algorithm>
#include <cmath>
#include <deque>

#include "lift.hpp"
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
constexpr int most_panes = 4;            // that one ray passes
constexpr double black = 0.03;           // reflectivity of a surface that returns few pulses
constexpr double black_returned = 0.3;   // this share
constexpr std::uint64_t world_seed = 1;  // of what belongs to the building's surfaces, whoever looks at them

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
  double strength = 1;                               // left of the light after the panes that it passed
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // of the surface; zero: round
  int object = -1;                                   // of the surface; -1: a person
};

// What one firing of all lasers met.
struct Shot {
  std::int64_t firing = 0;
  std::array<Eigen::Vector3d, packet_size> origin;
  std::array<Eigen::Vector3d, packet_size> direction;
  std::array<Echo, packet_size> echoes;
};

// A pane of window glass: with a coating that holds back heat it mirrors the LiDAR's light as well; half of them have one.
struct Pane {
  double reflected = 0.08;
  double absorbed = 0.0;
};

// Light that comes back relative to a white surface at 1 m that faces the sensor.
double power_of(const Echo& echo) {
  return echo.distance > 0 ? echo.reflectivity * echo.strength * echo.cosine / (echo.distance * echo.distance) : 0;
}

// Range at which the ray meets the plane of an echo of another ray; negative when it doesn't.
double range_to_plane(const Shot& ray, const Shot& other, std::size_t laser) {
  const Echo& echo = other.echoes[laser];
  const double across = echo.normal.dot(ray.direction[laser]);
  if (std::abs(across) < 1e-6) return -1;
  const Eigen::Vector3d on_plane = other.origin[laser] + echo.distance * other.direction[laser];
  return echo.normal.dot(on_plane - ray.origin[laser]) / across;
}

// The jump of the range between two neighbouring rays of a laser where one surface ends in front of another; 0 where both lie on one plane [m].
double edge_between(const Shot& a, const Shot& b, std::size_t laser) {
  constexpr double least_jump = 0.15;
  const double da = a.echoes[laser].distance;
  const double db = b.echoes[laser].distance;
  if (da <= 0 || db <= 0 || std::abs(da - db) < least_jump) return 0;
  if (std::abs(range_to_plane(b, a, laser) - db) < least_jump || std::abs(range_to_plane(a, b, laser) - da) < least_jump) return 0;
  return std::abs(da - db);
}

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
        intensity_noise_(settings.seed, static_cast<std::uint64_t>(Stream::intensity)),
        mixed_pixel_(settings.seed, static_cast<std::uint64_t>(Stream::mixed_pixel)),
        texture_(world_seed, static_cast<std::uint64_t>(Stream::texture)),
        colour_(world_seed, static_cast<std::uint64_t>(Stream::colour)),
        real_(settings.unit.kind == SensorKind::real) {
    for (std::size_t i = 0; i < world.lifts.size(); ++i) lifts_.emplace_back(world, i, motion_);
    for (int i = 0; i < azimuth_steps; ++i) circle_.emplace_back(std::cos(2 * M_PI * i / azimuth_steps), std::sin(2 * M_PI * i / azimuth_steps));
    for (int ring = 0; ring < vlp16::lasers; ++ring) {
      const double nominal = vlp16::elevation(ring);
      const double true_one = nominal + settings.unit.elevation_offset[static_cast<std::size_t>(ring)];
      elevation_.emplace_back(std::cos(nominal), std::sin(nominal));
      beam_.emplace_back(std::cos(true_one), std::sin(true_one));
    }
  }

  Cloud scan(int number, double stamp_time) const {
    Cloud cloud;
    const std::int64_t first = vlp16::first_firing(number, settings_.rate);
    const std::int64_t last = vlp16::first_firing(number + 1, settings_.rate);
    cloud.points.reserve(static_cast<std::size_t>(last - first) * vlp16::lasers);
    // A real sensor's mixed pixels need a look at the neighbouring firings.
    const std::int64_t margin = real_ ? 1 : 0;
    Frame begin = frame_at(settings_.motion_distortion ? static_cast<double>(first - margin) * vlp16::firing_interval : stamp_time);
    std::deque<Shot> shots;
    std::vector<LiftTrack> lifts = lifts_;  // at the moment of a firing
    for (std::int64_t firing = first - margin; firing < last + margin; ++firing) {
      const Frame end = settings_.motion_distortion ? frame_at(static_cast<double>(firing + 1) * vlp16::firing_interval) : begin;
      for (LiftTrack& lift : lifts) lift.move_to(static_cast<double>(firing) * vlp16::firing_interval);
      shots.push_back(fire(firing, begin, end, lifts));
      begin = end;
      if (!real_) {
        report(shots.front(), stamp_time, cloud.points);
        shots.pop_front();
      } else if (shots.size() == 3) {
        report(mixed(shots[0], shots[1], shots[2]), stamp_time, cloud.points);
        shots.pop_front();
      }
    }
    return cloud;
  }

 private:
  [[nodiscard]] Frame frame_at(double time) const {
    const Pose pose = motion_(time) * T_base_lidar_;
    return {pose.matrix(), pose.translation};
  }

  [[nodiscard]] Shot fire(std::int64_t firing, const Frame& begin, const Frame& end, const std::vector<LiftTrack>& lifts) const {
    const double time = static_cast<double>(firing) * vlp16::firing_interval;
    RayPacket rays;
    for (std::size_t n = 0; n < vlp16::lasers; ++n) {
      const double offset = static_cast<double>(n) * vlp16::laser_interval;
      const double f = offset / vlp16::firing_interval;
      const double turned = (time + offset) * settings_.rate;
      const double azimuth = -2 * M_PI * (turned - std::floor(turned));
      const auto ring = static_cast<std::size_t>(vlp16::ring_of_laser[n]);
      const Eigen::Vector2d& e = beam_[ring];
      const Eigen::Vector3d direction(e.x() * std::cos(azimuth), e.x() * std::sin(azimuth), e.y());
      rays.direction[n] = ((1 - f) * (begin.rotation * direction) + f * (end.rotation * direction)).normalized();
      rays.origin[n] = (1 - f) * begin.origin + f * end.origin;
      if (real_) rays.origin[n] += settings_.unit.origin_height[ring] * begin.rotation.col(2);
      rays.active[n] = true;
    }
    Shot shot;
    shot.firing = firing;
    shot.origin = rays.origin;
    shot.direction = rays.direction;
    trace(rays, firing, lifts, shot.echoes);
    return shot;
  }

  // The middle one of three firings with the points that float between two surfaces: where the beam strikes an edge it is partly on both.
  [[nodiscard]] Shot mixed(const Shot& before, const Shot& shot, const Shot& after) const {
    Shot result = shot;
    for (std::size_t n = 0; n < vlp16::lasers; ++n) {
      if (float_at_edge(before, shot, n, shot, result.echoes[n])) continue;
      float_at_edge(shot, after, n, shot, result.echoes[n]);
    }
    return result;
  }

  // Whether the edge between two firings is one with a mixed pixel, and `of` the firing that has it; then moves its echo.
  bool float_at_edge(const Shot& first, const Shot& second, std::size_t laser, const Shot& of, Echo& echo) const {
    const double jump = edge_between(first, second, laser);
    if (jump == 0) return false;
    const std::uint64_t index = 3 * ray_index(first.firing, laser);
    if (mixed_pixel_.uniform(index) > mixed_pixel_share(jump)) return false;
    if ((mixed_pixel_.uniform(index + 1) < 0.5) != (of.firing == first.firing)) return false;
    const double share = 0.1 + 0.8 * mixed_pixel_.uniform(index + 2);
    const Echo& a = first.echoes[laser];
    const Echo& b = second.echoes[laser];
    echo.distance = a.distance + share * (b.distance - a.distance);
    echo.reflectivity = std::min(a.reflectivity, b.reflectivity);
    return true;
  }

  // Follows the rays through panes to the surface that returns them; distance 0 when none does.
  void trace(RayPacket& rays, std::int64_t firing, const std::vector<LiftTrack>& lifts, std::array<Echo, packet_size>& echoes) const {
    std::array<Echo, packet_size> people = trace_people(rays, firing);
    add_lifts(rays, lifts, people);
    std::array<double, packet_size> strength;
    strength.fill(1.0);
    RayPacket mirrored;
    std::array<double, packet_size> mirrored_strength{};
    std::array<double, packet_size> to_pane{};
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
          const Pane glass = pane_of(hits.surface[n]->object);
          const double reflected = glass.reflected + (1 - glass.reflected) * std::pow(1 - hits.cosine[n], 5);
          strength[n] *= real_ ? std::pow((1 - reflected) * (1 - glass.absorbed), 2) : through_pane(hits.cosine[n]);
          if (real_ && pane == 0) {
            const Eigen::Vector3d& normal = hits.normal[n];
            mirrored.origin[n] = rays.origin[n] + hits.distance[n] * rays.direction[n];
            mirrored.direction[n] = rays.direction[n] - 2 * normal.dot(rays.direction[n]) * normal;
            mirrored.begin[n] = 1e-3;
            mirrored.active[n] = true;
            mirrored_strength[n] = reflected * reflected;
            to_pane[n] = hits.distance[n];
          }
          rays.begin[n] = hits.distance[n] + 1e-3;
          rays.active[n] = more = true;
        } else {
          const Eigen::Vector3d at = rays.origin[n] + hits.distance[n] * rays.direction[n];
          echoes[n] = {hits.distance[n], hits.cosine[n], shade(*hits.surface[n], at), strength[n], hits.normal[n], hits.surface[n]->object};
        }
      }
      if (!more) break;
    }
    if (real_) add_mirror_images(mirrored, mirrored_strength, to_pane, echoes);
  }

  // The sensor reports the strongest echo: behind a pane often what stands before it, as if the room went on there. One reflection each way.
  void add_mirror_images(const RayPacket& rays, const std::array<double, packet_size>& strength, const std::array<double, packet_size>& to_pane,
                         std::array<Echo, packet_size>& echoes) const {
    if (std::none_of(rays.active.begin(), rays.active.end(), [](bool active) { return active; })) return;
    const HitPacket hits = scene_.cast(rays);
    for (std::size_t n = 0; n < packet_size; ++n) {
      if (!rays.active[n] || hits.surface[n] == nullptr || hits.surface[n]->material == Material::glass) continue;
      const Eigen::Vector3d at = rays.origin[n] + hits.distance[n] * rays.direction[n];
      Echo image{to_pane[n] + hits.distance[n], hits.cosine[n], shade(*hits.surface[n], at), strength[n], Eigen::Vector3d::Zero(), -1};
      if (power_of(image) > power_of(echoes[n])) echoes[n] = image;
    }
  }

  [[nodiscard]] Pane pane_of(int object) const {
    if (colour_.uniform(static_cast<std::uint64_t>(object)) < 0.5) return {};
    return {0.3, 0.2};
  }

  // Reflectivity of a surface. To a real sensor every wall, floor and piece of furniture has its own shade, in patches of half a metre (posters, worn
  // paint); a quarter of the furniture is black, and one patch of a wall in thirty (screens, boards).
  [[nodiscard]] double shade(const Surface& surface, const Eigen::Vector3d& at) const {
    const double usual = reflectivity(surface.material);
    if (!real_) return usual;
    const double u = colour_.uniform(static_cast<std::uint64_t>(surface.object));
    const double patch = colour_.uniform((1ULL << 62) | cell_index(at, 0.5));
    if (surface.kind == SurfaceKind::furniture ? u < 0.25 : surface.kind == SurfaceKind::wall && patch < 0.033) return black;
    return usual * (0.3 + 0.7 * u) * (0.6 + 0.4 * patch);
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
          echoes[n] = {distance, cosine, reflectivity(Material::fabric), 1, Eigen::Vector3d::Zero(), -1};
      }
    }
    return echoes;
  }

  // What moves stands in front of what doesn't: people, cabins and their doors.
  static void add_lifts(const RayPacket& rays, const std::vector<LiftTrack>& lifts, std::array<Echo, packet_size>& echoes) {
    for (const LiftTrack& lift : lifts) {
      for (std::size_t n = 0; n < packet_size; ++n) {
        const LiftHit hit = lift.cast(rays.origin[n], rays.direction[n]);
        if (std::isfinite(hit.distance) && (echoes[n].distance == 0 || hit.distance < echoes[n].distance))
          echoes[n] = {hit.distance, hit.cosine, reflectivity(Material::metal), 1, hit.normal, -1};
      }
    }
  }

  static std::uint64_t ray_index(std::int64_t firing, std::size_t laser) { return static_cast<std::uint64_t>(firing) * vlp16::lasers + laser; }

  void report(const Shot& shot, double stamp_time, std::vector<Point>& points) const {
    for (std::size_t n = 0; n < vlp16::lasers; ++n) report(shot, n, stamp_time, points);
  }

  // Reported minus true range of a real sensor [m].
  [[nodiscard]] double real_error(const Shot& shot, std::size_t laser, double intensity) const {
    const Echo& echo = shot.echoes[laser];
    const int ring = vlp16::ring_of_laser[laser];
    const double white = white_noise(intensity, echo.cosine) * range_noise_.normal(ray_index(shot.firing, laser));
    return settings_.unit.range_offset[static_cast<std::size_t>(ring)] + settings_.unit.sine(ring, shot.firing) + intensity_bias(intensity) +
           texture_at(shot.origin[laser] + echo.distance * shot.direction[laser], echo.object) + white;
  }

  // What belongs to the spot of the surface: the same whenever the beam comes back to it. 3 to 5 mm by surface, in cells of 1 and of 6 cm.
  [[nodiscard]] double texture_at(const Eigen::Vector3d& p, int object) const {
    if (object < 0) return 0;
    const double size = 0.003 + 0.002 * colour_.uniform((1ULL << 32) + static_cast<std::uint64_t>(object));
    return size * (0.4 * texture_.normal(cell_index(p, 0.012)) + 0.92 * texture_.normal(cell_index(p, 0.06)));
  }

  // Number of the cube of the given size in which a point lies; good for buildings of kilometres.
  static std::uint64_t cell_index(const Eigen::Vector3d& p, double size) {
    const Eigen::Array3d at = (p.array() / size + 0.37).floor();
    const auto part = [](double x) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(x)) & 0x1fffffU; };
    return part(at.x()) << 42 | part(at.y()) << 21 | part(at.z());
  }

  void report(const Shot& shot, std::size_t laser, double stamp_time, std::vector<Point>& points) const {
    const std::int64_t firing = shot.firing;
    const Echo& echo = shot.echoes[laser];
    if (echo.distance <= 0) return;
    const std::uint64_t index = ray_index(firing, laser);
    const double returned = real_ && echo.reflectivity <= black ? black_returned : 1.0;
    if (detection_.uniform(index) > returned * detection_probability(echo)) return;
    const double incidence = real_ ? echo.cosine : 0.4 + 0.6 * echo.cosine;
    const double bright = 100 * echo.reflectivity * incidence * echo.strength + 2 * intensity_noise_.normal(index);
    const double intensity = std::round(std::min(255.0, std::max(real_ ? 1.0 : 0.0, bright)));
    double noisy = echo.distance;
    if (real_) {
      noisy += real_error(shot, laser, intensity);
    } else if (settings_.range_noise > 0) {
      noisy += settings_.range_noise * range_noise_.normal(index);
    }
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
    point.intensity = static_cast<float>(intensity);
    point.time = settings_.motion_distortion ? static_cast<float>(time - stamp_time) : 0.0F;
    point.ring = static_cast<std::uint16_t>(ring);
    points.push_back(point);
  }

  PoseFunction motion_;
  Pose T_base_lidar_;
  LidarSettings settings_;
  Scene scene_;
  std::vector<PersonTrack> people_;
  std::vector<LiftTrack> lifts_;
  RandomStream range_noise_;
  RandomStream detection_;
  RandomStream glass_;
  RandomStream intensity_noise_;
  RandomStream mixed_pixel_;
  RandomStream texture_;
  RandomStream colour_;
  bool real_;
  std::vector<Eigen::Vector2d> circle_;     // cosine, sine of each reported azimuth
  std::vector<Eigen::Vector2d> elevation_;  // cosine, sine by ring, as reported
  std::vector<Eigen::Vector2d> beam_;       // and as they are
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
