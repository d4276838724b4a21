// A ride in a simulated lift: the odometry tells it, and keeps place and heading.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "sgraph_slam/core/odometry/odometry.hpp"
#include "sgraph_slam/core/prefilter/prefilter.hpp"
#include "sgraph_slam/core/sim/proprioception.hpp"
#include "sgraph_slam/core/sim/simulator.hpp"
#include "support/lift_building.hpp"

namespace sgraph {
namespace {

const std::string two_floors =
    building_with_lift("4.5", "{stand: 1, return: false, waypoints: [[3, 3], {at: [8, 3], ride: 1}, [5.5, 3], [5.5, 1.5]]}");

struct Followed {
  Trajectory finals;
  Trajectory truth;
  std::vector<Keyframe> keyframes;
};

// `imu`: readings of the whole ride.
Followed follow(const sim::World& world, const std::vector<ImuSample>& imu = {}) {
  const sim::Motion motion = sim::motion_along_route(world);
  const int count = static_cast<int>(10 * motion.duration()) - 2;
  const Prefilter prefilter({});
  std::unique_ptr<Odometry> odometry;
  Followed run;
  const auto take = [&run](const OdometryOutput& output) {
    run.finals.insert(run.finals.end(), output.finals.begin(), output.finals.end());
    run.keyframes.insert(run.keyframes.end(), output.keyframes.begin(), output.keyframes.end());
  };
  std::size_t readings = 0;
  for (int first = 0; first < count; first += 50) {  // a piece of it in memory at a time
    const sim::SimulatedScans scans = sim::simulate_scans(world, std::min(50, count - first), {}, first);
    if (!odometry) odometry = std::make_unique<Odometry>(OdometryParams{}, scans.T_base_lidar);
    for (const CloudPtr& scan : scans.scans) {
      while (readings < imu.size() && imu[readings].stamp <= scan->stamp.after(0.1)) odometry->add(imu[readings++]);
      take(odometry->process(prefilter.process(*scan).cloud));
    }
    run.truth.insert(run.truth.end(), scans.truth.begin(), scans.truth.end());
  }
  take(odometry->finish());
  return run;
}

TEST(LiftRide, IsToldAndKeepsPlaceAndHeading) {
  const sim::World world = sim::parse_world(two_floors);
  const Followed run = follow(world);
  ASSERT_EQ(run.finals.size(), run.truth.size());
  int rides = 0;
  for (const Keyframe& keyframe : run.keyframes) {
    if (!keyframe.ride) continue;
    ++rides;
    const Eigen::Vector3d up = keyframe.T_odom_base.matrix().transpose().col(2);
    EXPECT_GT(up.dot(keyframe.covariance.bottomRightCorner<3, 3>() * up), 50);
    const Eigen::Matrix3d on_ground = Eigen::Matrix3d::Identity() - up * up.transpose();
    EXPECT_LT((on_ground * keyframe.covariance.bottomRightCorner<3, 3>() * on_ground).trace(), 0.1);
  }
  EXPECT_EQ(rides, 1);
  const Pose T_truth_odom = run.truth.front().pose * run.finals.front().pose.inverse();
  const Pose end = T_truth_odom * run.finals.back().pose;
  const Pose truth = run.truth.back().pose;
  EXPECT_LT((end.translation - truth.translation).head<2>().norm(), 0.02);
  const Eigen::Quaterniond error = end.rotation * truth.rotation.conjugate();
  EXPECT_LT(std::abs(2 * error.z()), 0.1 * M_PI / 180);
  EXPECT_LT(2 * error.vec().head<2>().norm(), 0.75 * M_PI / 180);
}

// 2 cm here.
TEST(LiftRide, IsMeasuredByAnAccelerometer) {
  const sim::World world = sim::parse_world(two_floors);
  const sim::Motion motion = sim::motion_along_route(world);
  const Followed run = follow(world, sim::simulate_imu(motion, motion.duration(), {}, 1, sim::LidarSettings{}.start));
  const auto ridden = std::find_if(run.keyframes.begin(), run.keyframes.end(), [](const Keyframe& keyframe) { return keyframe.ride.has_value(); });
  ASSERT_NE(ridden, run.keyframes.end());
  const double height = world.storeys[1].elevation - world.storeys[0].elevation;
  EXPECT_LT(ridden->ride->sigma, 0.3);
  EXPECT_LT(std::abs(ridden->ride->height - height), std::min(0.3, 3 * ridden->ride->sigma));
}

}  // namespace
}  // namespace sgraph
