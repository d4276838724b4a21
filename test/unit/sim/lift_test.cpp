#include <gtest/gtest.h>

#include <cmath>

#include "sgraph_slam/core/sim/lidar.hpp"
#include "sgraph_slam/core/sim/motion.hpp"
#include "support/lift_building.hpp"

namespace sgraph::sim {
namespace {

const std::string with_lift = building_with_lift("4", "{return: false, waypoints: [[2, 3], {at: [8, 3], ride: 1}, [5, 3]]}");

double farthest(const Cloud& cloud) {
  double most = 0;
  for (const Point& point : cloud.points) most = std::max(most, std::hypot(static_cast<double>(point.x), static_cast<double>(point.y)));
  return most;
}

TEST(Lift, CarriesTheRobotAndNothingButTheCabinIsSeenMeanwhile) {
  const World world = parse_world(with_lift);
  ASSERT_EQ(world.lifts.size(), 1U);
  const Motion motion = motion_along_route(world);
  EXPECT_NEAR(motion.pose_at(motion.duration()).translation.z(), 3.2 + world.motion.base_height, 1e-6);
  LidarSettings settings;
  settings.range_noise = 0;
  const Lidar lidar(
      world, [&motion](double t) { return motion.pose_at(t); }, settings);
  double rode = 0;
  for (int scan = 0; lidar.time_of(scan) < motion.duration(); ++scan) {
    const Pose pose = motion.pose_at(lidar.time_of(scan));
    const double floor = pose.translation.z() - world.motion.base_height;
    if (floor > 0.3 && floor < 2.9) {
      rode += 0.1;
      EXPECT_LT(farthest(lidar.scan(scan)), 2.2) << "at " << floor;
      EXPECT_NEAR(pose.translation.x(), 8, 1e-6);
    }
  }
  EXPECT_GT(rode, 2.0);
  EXPECT_GT(farthest(lidar.scan(10)), 3.0);
}

TEST(Lift, FaultsAreNamed) {
  const std::string& text = with_lift;
  const auto fault = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    try {
      parse_world(changed);
    } catch (const WorldError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(fault("door: [7.2, 3]", "door: [7.6, 3]").find("must lie on a side"), std::string::npos);
  EXPECT_NE(fault("ride: 1", "ride: 0").find("on the storey that it is to"), std::string::npos);
  EXPECT_NE(fault("{at: [8, 3], ride: 1}", "{at: [5, 3], ride: 1}").find("only in a lift"), std::string::npos);
}

}  // namespace
}  // namespace sgraph::sim
