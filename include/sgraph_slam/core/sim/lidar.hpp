#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sgraph_slam/core/sim/scene.hpp"
#include "sgraph_slam/core/sim/sensor_unit.hpp"
#include "sgraph_slam/core/sim/world.hpp"
#include "sgraph_slam/core/types/cloud.hpp"

namespace sgraph::sim {

/// Velodyne VLP-16 (User's manual 63-9243): 16 lasers fire one after the other, the head turns clockwise seen from above, starting ahead (+x).
namespace vlp16 {
constexpr int lasers = 16;
constexpr double laser_interval = 2.304e-6;    ///< from one laser to the next [s]
constexpr double firing_interval = 55.296e-6;  ///< from one firing of all lasers to the next, with the pause for recharging [s]
constexpr double range_step = 0.002;           ///< of the reported distance [m]
constexpr double azimuth_step_deg = 0.01;      ///< of the reported azimuth
/// Ring, counted from the lowest beam, of the n-th laser of a firing.
constexpr std::array<int, lasers> ring_of_laser{0, 8, 1, 9, 2, 10, 3, 11, 4, 12, 5, 13, 6, 14, 7, 15};

/// Elevation of a ring: -15 to +15 degrees in steps of 2 [rad].
double elevation(int ring);
/// Number of the first firing of a revolution at `rate` [Hz]; firings are counted from the start of the recording.
std::int64_t first_firing(int scan, double rate);
}  // namespace vlp16

/// Which firing gives the cloud its stamp: the driver can be set to either.
enum class StampConvention { first, last };

struct LidarSettings {
  double range_noise = 0.02;  ///< standard deviation of the ideal sensor; a real one has its own [m]
  SensorUnit unit;            ///< errors of the sensor; none by default
  double rate = 10;           ///< revolutions, so scans, a second; the sensor can be set to 5 .. 20 (300 .. 1200 rpm)
  double min_range = 0.4;     ///< [m]
  double max_range = 100.0;   ///< [m]
  /// Off: a whole scan is seen from the LiDAR's pose at its stamp, and its points carry time 0, as an already motion-compensated cloud does.
  bool motion_distortion = true;
  StampConvention stamp = StampConvention::last;
  std::uint64_t seed = 1;
  std::string frame = "velodyne";
  std::int64_t start = 1'600'000'000'000'000'000;  ///< stamp of the recording's first firing [ns]
};

/// Pose of base_link in the world by the seconds since the start of the recording.
using PoseFunction = std::function<Pose(double)>;

/// Simulates scans of a VLP-16 carried through a world. Each scan is a function of the world, the settings and its number alone, so scans may be
/// asked for in any order and from several threads.
///
/// What happens to a ray: the nearest surface or person returns it, unless the echo is too weak (dark, far, or grazing) or is lost by chance. Glass
/// returns it at near-normal incidence only; otherwise it goes on to what lies behind, weaker. The range gets white noise and is rounded to the
/// sensor's steps, as is the azimuth. A real unit (docs/simulator.md, The real sensor) adds its systematic errors, mixed pixels at edges, mirror
/// images in panes, and surfaces of all shades up to those that return nothing.
class Lidar {
 public:
  Lidar(const World& world, PoseFunction motion, const LidarSettings& settings);
  ~Lidar();

  /// The points of one revolution in the order of firing, in the LiDAR's frame of each firing's moment.
  [[nodiscard]] Cloud scan(int number) const;
  [[nodiscard]] Stamp stamp_of(int number) const;
  /// Seconds from the start of the recording to the scan's stamp, and to its last firing.
  [[nodiscard]] double time_of(int number) const;
  [[nodiscard]] double end_of(int number) const;
  [[nodiscard]] const LidarSettings& settings() const { return settings_; }

 private:
  class Implementation;
  LidarSettings settings_;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sgraph::sim
