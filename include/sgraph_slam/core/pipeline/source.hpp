#pragma once

#include <optional>
#include <variant>

#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/sensor.hpp"

namespace sgraph {

/// A raw scan in the LiDAR's frame (`ring`, `time` and `intensity` are 0 where the sensor doesn't give them), a pose of the robot's odometry, or an
/// inertial reading.
using SensorEvent = std::variant<CloudPtr, OdometrySample, ImuSample>;

/// Where sensor data comes from: a bag or the simulator. Events come in the order in which they would reach a robot's computer.
class SensorSource {
 public:
  virtual ~SensorSource() = default;

  /// The next event, or nothing at the end. Throws std::runtime_error when the source is broken beyond going on.
  virtual std::optional<SensorEvent> next() = 0;

  /// Pose of the LiDAR on the robot, known before the first scan.
  [[nodiscard]] virtual Pose T_base_lidar() const = 0;

  /// Number of scans in all, for progress; 0 when unknown.
  [[nodiscard]] virtual int scan_count() const = 0;
};

}  // namespace sgraph
