#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/pipeline/source.hpp"
#include "sgraph_slam/core/sensor/description.hpp"
#include "sgraph_slam/core/sensor/params.hpp"
#include "sgraph_slam/ros/conversions.hpp"

namespace sgraph {

struct BagOptions {
  std::vector<std::string> bags;
  std::string points_topic;  ///< sensor_msgs/PointCloud2 or velodyne_msgs/VelodyneScan; empty: the only one of the recording
  std::string odom_topic;    ///< empty: none
  std::string imu_topic;     ///< empty: none
  std::string base_frame = "base_link";
  std::string lidar_frame;           ///< only scans of this frame, or the frame of clouds that name none; empty: what the clouds say
  std::optional<Pose> T_base_lidar;  ///< in place of /tf_static
  double start = 0;                  ///< seconds of the recording to leave out at its beginning
  std::optional<double> duration;    ///< seconds to read; nothing: to the end
  SensorParams sensor;               ///< conventions of the clouds
};

/// A recording: one or several ROS bags, their messages merged by the time at which they were recorded. The conventions of the clouds are recognised
/// from the first of them (SensorAdapter). Scans wait until the odometry and the inertial unit, where they are read, cover them (ScanGate).
class BagSource : public SensorSource {
 public:
  /// Throws std::runtime_error with one sentence: a file that is missing, no bag, truncated or empty; a topic that isn't there (with those that
  /// are) or is of another type; several topics with clouds, or several LiDARs on the topic, of which one must be chosen; no scan in the chosen
  /// time; no scan that can be used; a transform that /tf_static doesn't hold.
  explicit BagSource(const BagOptions& options);
  ~BagSource() override;

  /// Throws std::runtime_error where the file is damaged. A scan or reading that can't be used is left out and counted.
  std::optional<SensorEvent> next() override;
  [[nodiscard]] Pose T_base_lidar() const override;
  [[nodiscard]] int scan_count() const override;

  /// Topic and frame of the clouds.
  [[nodiscard]] const std::string& points_topic() const;
  [[nodiscard]] const std::string& lidar_frame() const;
  /// Scans left out, by reason.
  [[nodiscard]] const std::map<MessageFault, int>& dropped() const;
  /// Readings of the robot's odometry and of the inertial unit left out, by topic and reason.
  [[nodiscard]] const std::map<std::string, int>& readings_dropped() const;
  /// What was recognised of the LiDAR.
  [[nodiscard]] const SensorDescription& sensor() const;
  /// What else there is to say of the recording, a sentence each; complete when `next` has returned nothing.
  [[nodiscard]] const std::vector<std::string>& notes() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sgraph
