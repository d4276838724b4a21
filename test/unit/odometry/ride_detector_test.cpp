#include "sgraph_slam/core/odometry/ride_detector.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace sgraph {
namespace {

const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();

// A cabin of 2 x 2 m with the sensor in its middle and a door of 1 m on its +x side (`opposite`: -x), before a room whose far wall is `depth` m from
// the sensor. Rings of -0.2 to 0.6 m of height at the walls.
Cloud view(bool open, double depth, bool opposite = false) {
  Cloud cloud;
  for (int a = 0; a < 720; ++a) {
    const double azimuth = 2 * M_PI * a / 720;
    const Eigen::Vector2d d(std::cos(azimuth), std::sin(azimuth));
    const double ahead = opposite ? -d.x() : d.x();
    double range = 1 / std::max(std::abs(d.x()), std::abs(d.y()));
    if (open && ahead > 0 && std::abs(range * d.y()) < 0.5 && range * ahead > 0.99) range = depth / ahead;
    for (int ring = 0; ring < 9; ++ring) {
      Point point;
      const double slope = (-0.2 + 0.1 * ring) / (open ? 4 : 1);
      point.set_position(Eigen::Vector3d(range * d.x(), range * d.y(), range * slope).cast<float>());
      cloud.points.push_back(point);
    }
  }
  return cloud;
}

// Whether the robot was carried, once that is decided.
bool carried(RideDetector& detector, const Cloud& open, const Pose& pose = {}) {
  for (int i = 0; i < 10; ++i) {
    const RideDetector::Seen seen = detector.see(open, pose, up);
    if (seen != RideDetector::Seen::nothing) return seen == RideDetector::Seen::another_floor;
  }
  EXPECT_FALSE(detector.shut()) << "undecided";
  return false;
}

bool carried_after(int scans_shut, double depth_before, double depth_after, int scans_open = 1) {
  RideDetector detector;
  for (int i = 0; i < scans_open; ++i) EXPECT_EQ(detector.see(view(true, depth_before), {}, up), RideDetector::Seen::nothing);
  for (int i = 0; i < scans_shut; ++i) EXPECT_EQ(detector.see(view(false, 0), {}, up), RideDetector::Seen::nothing);
  return carried(detector, view(true, depth_after));
}

TEST(RideDetector, DoorsThatOpenOnAnotherFloor) {
  EXPECT_TRUE(carried_after(80, 4, 6));
  EXPECT_TRUE(carried_after(80, 6, 4));
}

// All that is seen through the doors is as near as a cabin may be wide.
TEST(RideDetector, DoorsOnANarrowCorridor) {
  EXPECT_TRUE(carried_after(80, 2.2, 6));
  EXPECT_TRUE(carried_after(80, 6, 2.2));
  EXPECT_FALSE(carried_after(80, 2.2, 2.2));
  EXPECT_TRUE(carried_after(80, 2.2, 6, 40));  // the robot waits for the doors to shut
  EXPECT_FALSE(carried_after(80, 2.2, 2.2, 40));
}

TEST(RideDetector, DoorsThatShutAndOpenOnTheSameFloor) { EXPECT_FALSE(carried_after(80, 4, 4)); }

TEST(RideDetector, ADoorThatIsShutForAMomentIsNoRide) { EXPECT_FALSE(carried_after(10, 4, 6)); }

// A small room with two doors.
TEST(RideDetector, AnotherDoorThanTheOneBeforeIsNoRide) {
  RideDetector detector;
  detector.see(view(true, 4), {}, up);
  for (int i = 0; i < 80; ++i) detector.see(view(false, 0), {}, up);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(detector.see(view(true, 6, true), {}, up), RideDetector::Seen::nothing);
  const Pose outside{Eigen::Quaterniond::Identity(), Eigen::Vector3d(-1.2, 0, 0)};
  EXPECT_EQ(detector.see(view(true, 6, true), outside, up), RideDetector::Seen::another_door);
  EXPECT_FALSE(detector.shut());
}

TEST(RideDetector, ARobotThatTurnsInTheCabinRides) {
  RideDetector detector;
  const auto turned = [](double angle) { return Pose{Eigen::Quaterniond(Eigen::AngleAxisd(angle, up)), Eigen::Vector3d::Zero()}; };
  const auto seen = [](const Cloud& cloud, const Pose& pose) {
    Cloud own = cloud;
    for (Point& point : own.points) point.set_position((pose.inverse() * point.position().cast<double>()).cast<float>());
    return own;
  };
  detector.see(view(true, 4), {}, up);
  for (int i = 0; i < 80; ++i) detector.see(seen(view(false, 0), turned(0.04 * i)), turned(0.04 * i), up);
  EXPECT_TRUE(detector.shut());
  EXPECT_TRUE(carried(detector, seen(view(true, 6), turned(3.2)), turned(3.2)));
}

// What is seen goes along with it: no room is that.
TEST(RideDetector, WhoWalksIsInNoCabin) {
  RideDetector detector;
  for (int i = 0; i < 60; ++i) {
    const Pose walking{Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.02 * i, 0, 0)};
    detector.see(view(false, 0), walking, up);
    EXPECT_FALSE(detector.shut());
  }
}

TEST(RideDetector, ARoomOrACorridorIsNoCabin) {
  RideDetector detector;
  Cloud room = view(false, 0);
  Cloud corridor = room;
  for (Point& point : room.points) point.set_position(4 * point.position());
  for (Point& point : corridor.points) {
    if (std::abs(point.x) > 0.99F) point.set_position(8 * point.position());
  }
  for (const Cloud& cloud : {room, corridor}) {
    for (int i = 0; i < 60; ++i) EXPECT_EQ(detector.see(cloud, {}, up), RideDetector::Seen::nothing);
    EXPECT_FALSE(detector.shut());
  }
}

TEST(RideDetector, OnlyTheCabinIsKeptWhileTheDoorsOpen) {
  RideDetector detector;
  for (int i = 0; i < 40; ++i) detector.see(view(false, 0), {}, up);
  EXPECT_TRUE(detector.shut());
  const CloudPtr inside = detector.within_cabin(view(true, 6), {});
  EXPECT_LT(inside->size(), view(true, 6).size());
  for (const Point& point : inside->points) EXPECT_LT(std::hypot(point.x, point.y), 2.0F);
}

}  // namespace
}  // namespace sgraph
