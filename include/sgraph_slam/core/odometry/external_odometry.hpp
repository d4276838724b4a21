#pragma once

#include <deque>
#include <optional>

#include "sgraph_slam/core/odometry/motion_source.hpp"

namespace sgraph {

/// Motion from the robot's own odometry: interpolated to the scan's stamp, deskewed with it, nothing registered. Its poses are final at once.
class ExternalOdometry : public MotionSource {
 public:
  explicit ExternalOdometry(const Pose& T_base_lidar) : T_base_lidar_(T_base_lidar) {}

  void add(const OdometrySample& sample) override;
  void add(const ImuSample&) override {}
  MotionOutput process(const CloudPtr& scan) override;
  std::vector<FinalScan> finish() override { return {}; }

 private:
  Pose T_base_lidar_;
  std::deque<OdometrySample> samples_;  // in order of stamp, the last few seconds
  std::optional<Stamp> last_stamp_;
};

}  // namespace sgraph
