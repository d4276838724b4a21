#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/pipeline/source.hpp"
#include "sgraph_slam/ros/conversions.hpp"

namespace sgraph {

struct BagOptions {
  std::vector<std::string> bags;
  std::string points_topic = "/velodyne_points";
  std::string odom_topic;  ///< empty: none
  std::string imu_topic;   ///< empty: none
  std::string base_frame = "base_link";
  std::optional<Pose> T_base_lidar;  ///< in place of /tf_static
  double start = 0;                  ///< seconds of the recording to leave out at its beginning
  std::optional<double> duration;    ///< seconds to read; nothing: to the end
};

/// A recording: one or several ROS bags, their messages merged by the time at which they were recorded. Scans wait until the odometry and the
/// inertial unit, where they are read, cover them (ScanGate).
class BagSource : public SensorSource {
 public:
  /// Throws std::runtime_error with one sentence: a file that is missing, no bag, truncated or empty; a topic that isn't there (with those that
  /// are) or is of another type; no scan in the chosen time; a first scan that can't be used; a transform that /tf_static doesn't hold.
  explicit BagSource(const BagOptions& options);
  ~BagSource() override;

  /// Throws std::runtime_error where the file is damaged. A scan or reading that can't be used is left out and counted.
  std::optional<SensorEvent> next() override;
  [[nodiscard]] Pose T_base_lidar() const override;
  [[nodiscard]] int scan_count() const override;

  /// Frame of the clouds.
  [[nodiscard]] const std::string& lidar_frame() const;
  /// Scans left out, by reason.
  [[nodiscard]] const std::map<MessageFault, int>& dropped() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sgraph
