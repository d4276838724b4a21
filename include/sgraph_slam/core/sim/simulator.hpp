#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sgraph_slam/core/pipeline/source.hpp"
#include "sgraph_slam/core/sim/lidar.hpp"
#include "sgraph_slam/core/sim/motion.hpp"
#include "sgraph_slam/core/sim/proprioception.hpp"
#include "sgraph_slam/core/sim/world.hpp"

namespace sgraph::sim {

struct SimulationSettings {
  LidarSettings lidar;
  EncoderSettings encoders;
  ImuSettings imu;
  double duration = 0;  ///< ends the recording after this long; 0: the whole route [s]
};

/// A robot in a world as a source of sensor data, simulated on the fly: what a bag of the same world would give. Deterministic.
class SimulatedSource : public SensorSource {
 public:
  /// The robot follows the world's route. Throws WorldError.
  SimulatedSource(const World& world, const SimulationSettings& settings);
  /// It moves as given instead; the world's route and people who would be in its way are not looked at.
  SimulatedSource(const World& world, Motion motion, const SimulationSettings& settings);

  std::optional<SensorEvent> next() override;
  [[nodiscard]] Pose T_base_lidar() const override { return world_.T_base_lidar; }
  [[nodiscard]] int scan_count() const override { return scan_count_; }

  [[nodiscard]] const World& world() const { return world_; }
  [[nodiscard]] const Motion& motion() const { return motion_; }
  [[nodiscard]] const Lidar& lidar() const { return lidar_; }
  [[nodiscard]] double duration() const { return duration_; }

  /// True poses of base_link in the world at each scan's stamp.
  [[nodiscard]] Trajectory ground_truth() const;

  /// Velocities that came with the newest OdometrySample, for those who write it as a message.
  [[nodiscard]] const EncoderReading& last_encoder_reading() const { return encoders_[next_encoder_ > 0 ? next_encoder_ - 1 : 0]; }
  /// When the newest event reached the robot's computer.
  [[nodiscard]] Stamp last_arrival() const { return last_arrival_; }

 private:
  World world_;
  Motion motion_;
  SimulationSettings settings_;
  Lidar lidar_;
  double duration_;
  int scan_count_;
  std::vector<EncoderReading> encoders_;
  std::vector<ImuSample> imu_;
  std::size_t next_encoder_ = 0;
  std::size_t next_imu_ = 0;
  int next_scan_ = 0;
  Stamp last_arrival_;
};

/// Some scans with their truth, for tests of other stages.
struct SimulatedScans {
  std::vector<CloudPtr> scans;
  Trajectory truth;  ///< of base_link in the world, at the scans' stamps
  Pose T_base_lidar;
};

/// The scans first, first + 1, ... of a world; fewer when the recording ends before.
SimulatedScans simulate_scans(const World& world, int count, const LidarSettings& settings = {}, int first = 0);

/// What is true of a world as JSON (docs/worlds.md): rooms, corridors, walls, columns, surfaces, duration, length.
std::string truth_json(const World& world, const Motion& motion, double duration, const LidarSettings& lidar = {});

/// Of what a source simulates.
std::string truth_json(const SimulatedSource& source);

}  // namespace sgraph::sim
