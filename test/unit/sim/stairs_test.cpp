#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sgraph_slam/core/sim/simulator.hpp"

namespace sgraph::sim {
namespace {

constexpr const char* two_storeys = R"(
name: two_storeys
storeys:
  - elevation: 0
    height: 3.06
    ceiling_voids: [[[4, 0.2], [9, 1.8]]]
    walls: [{path: [[0, 0], [14, 0], [14, 2], [0, 2], [0, 0]], thickness: 0.2}]
    places: {below: [1, 1]}
  - elevation: 3.06
    height: 2.8
    floor_voids: [[[4, 0.2], [9, 1.8]]]
    walls: [{path: [[0, 0], [14, 0], [14, 2], [0, 2], [0, 0]], thickness: 0.2}]
    places: {above: [12, 1]}
stairs: [{from: [3.6, 1, 0], to: [9, 1, 3.06], width: 1.4}]
motion: {sway_roll_deg: 0, sway_pitch_deg: 0, sway_height: 0}
route: {return: false, waypoints: [[1, 1], [3.6, 1], {at: [9, 1], storey: 1}, [12.5, 1]]}
)";

TEST(Stairs, TheRobotClimbsThemAndPitches) {
  const World world = parse_world(two_storeys);
  const Motion motion = motion_along_route(world);
  const double base = world.motion.base_height;
  EXPECT_NEAR(motion.pose_at(0).translation.z(), base, 1e-9);
  EXPECT_NEAR(motion.pose_at(motion.duration()).translation.z(), 3.06 + base, 1e-6);
  double steepest = 0;
  for (double t = 0; t < motion.duration(); t += 0.05) {
    const Pose pose = motion.pose_at(t);
    const Eigen::Vector3d ahead = pose.rotation * Eigen::Vector3d::UnitX();
    steepest = std::max(steepest, std::asin(ahead.z()));
    if (pose.translation.x() > 5 && pose.translation.x() < 8) {
      EXPECT_NEAR(pose.translation.z() - base, (pose.translation.x() - 3.6) * 3.06 / 5.4, 0.01);
    }
  }
  EXPECT_NEAR(steepest, std::atan2(3.06, 5.4), 0.01);  // nose up
}

TEST(Stairs, StepsAreSeenAndVoidsLetThrough) {
  const World world = parse_world(two_storeys);
  const std::vector<Block> steps = stairs_of(world, true);
  ASSERT_EQ(steps.size(), 18U);
  EXPECT_NEAR(steps.back().center.z() + 0.5 * steps.back().size.z(), 3.06, 1e-9);
  const Eigen::Vector2d in_void(6, 1);
  int floors = 0;
  for (const Surface& surface : surfaces_of(world)) {
    if (surface.kind != SurfaceKind::floor || std::abs(surface.outline.front().z() - 3.06) > 1e-6) continue;
    ++floors;
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector3d& p : surface.outline) box.extend(Eigen::Vector2d(p.head<2>()));
    EXPECT_FALSE(box.contains(in_void));
  }
  EXPECT_EQ(floors, 4);
}

TEST(Stairs, TheTruthTellsTheStorey) {
  const World world = parse_world(two_storeys);
  const Motion motion = motion_along_route(world);
  const nlohmann::json truth = nlohmann::json::parse(truth_json(world, motion, motion.duration()));
  const nlohmann::json& path = truth.at("storey_of_path");
  ASSERT_EQ(path.size(), 3U);
  EXPECT_EQ(path[0].at("storey"), 0);
  EXPECT_TRUE(path[1].at("storey").is_null());
  EXPECT_EQ(path[2].at("storey"), 1);
  ASSERT_EQ(truth.at("places").size(), 2U);
  for (const nlohmann::json& place : truth.at("places")) EXPECT_TRUE(place.at("entered").get<bool>());
}

}  // namespace
}  // namespace sgraph::sim
