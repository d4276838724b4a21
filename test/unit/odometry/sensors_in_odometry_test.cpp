#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/odometry/odometry.hpp"
#include "sgraph_slam/core/prefilter/prefilter.hpp"
#include "sgraph_slam/core/sim/simulator.hpp"
#include "support/trajectory_error.hpp"

namespace sgraph {
namespace {

using Change = void (*)(ImuSample&, OdometrySample&);

// Error of the final poses over some seconds of a walk on which every second scan is lost for a while, with the sensors changed.
double ate_with(bool sensors, Change change) {
  const sim::World world = sim::read_world("worlds/demo.yaml");
  sim::SimulationSettings settings;
  settings.duration = 14;
  sim::SimulatedSource source(world, settings);
  const Prefilter prefilter({});
  Odometry odometry({}, source.T_base_lidar());
  Trajectory finals;
  int count = 0;
  while (auto event = source.next()) {
    ImuSample unused_imu;
    OdometrySample unused_odometry;
    if (auto* imu = std::get_if<ImuSample>(&*event)) {
      change(*imu, unused_odometry);
      if (sensors) odometry.add(*imu);
    } else if (auto* reading = std::get_if<OdometrySample>(&*event)) {
      change(unused_imu, *reading);
      if (sensors) odometry.add(*reading);
    } else {
      const bool gap = ++count > 60 && count % 5 != 0;  // 2 Hz
      if (gap) continue;
      for (const StampedPose& p : odometry.process(prefilter.process(*std::get<CloudPtr>(*event)).cloud).finals) finals.push_back(p);
    }
  }
  return test::ate(finals, source.ground_truth());
}

TEST(Odometry, GyroAndRobotOdometryHelpAcrossGapsAndWrongOnesDoNotHurt) {
  const Change as_they_are = [](ImuSample&, OdometrySample&) {};
  const double alone = ate_with(false, as_they_are);
  EXPECT_LT(alone, 0.012);
  EXPECT_LT(ate_with(true, as_they_are), 0.9 * alone);
  const Change wrong = [](ImuSample& imu, OdometrySample& odometry) {
    imu.angular_velocity = {0.5, -imu.angular_velocity.z(), 0.3 * std::sin(70 * imu.stamp.seconds())};
    odometry.T_odom_base.translation = {0.5 * odometry.stamp.seconds(), 0, 0};
    odometry.T_odom_base.rotation = so3_exp({0, 0, 0.2 * odometry.stamp.seconds()});
  };
  EXPECT_LT(ate_with(true, wrong), 1.5 * alone);
}

}  // namespace
}  // namespace sgraph
