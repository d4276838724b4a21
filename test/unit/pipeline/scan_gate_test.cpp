#include "sgraph_slam/core/pipeline/scan_gate.hpp"

#include <gtest/gtest.h>

#include <string>

namespace sgraph {
namespace {

Stamp at(double seconds) { return Stamp::from_seconds(100 + seconds); }

CloudPtr scan(double stamp, float first, float last) {
  auto cloud = std::make_shared<Cloud>();
  cloud->stamp = at(stamp);
  cloud->points.resize(2);
  cloud->points[0].time = first;
  cloud->points[1].time = last;
  return cloud;
}
OdometrySample odometry(double stamp) { return {at(stamp), Pose(), Matrix6::Zero()}; }
ImuSample imu(double stamp) { return {at(stamp), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}; }

// Everything that may pass now, a letter an event.
std::string passed(ScanGate& gate) {
  std::string text;
  while (const auto event = gate.pop()) text += "soi"[event->index()];
  return text;
}

TEST(ScanGate, WithoutOtherSensorsEveryScanPassesAtOnce) {
  ScanGate gate(false, false);
  gate.push(scan(0, 0, 0.1F));
  EXPECT_EQ(passed(gate), "s");
  gate.push(odometry(0));
  gate.push(scan(0.1, -0.1F, 0));
  EXPECT_EQ(passed(gate), "os");
}

TEST(ScanGate, AScanWaitsForTheOdometryOfItsLastFiring) {
  ScanGate gate(true, false);
  gate.push(scan(0, 0, 0.1F));
  gate.push(odometry(0.08));
  EXPECT_EQ(passed(gate), "o");
  gate.push(odometry(0.101));
  EXPECT_EQ(passed(gate), "os");
  gate.push(scan(0.2, -0.1F, 0));  // stamped at its end
  gate.push(imu(0.21));
  EXPECT_EQ(passed(gate), "i");
  gate.push(odometry(0.2));
  EXPECT_EQ(passed(gate), "os");
}

TEST(ScanGate, BothSensorsMustHaveCome) {
  ScanGate gate(true, true);
  gate.push(scan(0, 0, 0.1F));
  gate.push(odometry(0.12));
  EXPECT_EQ(passed(gate), "o");
  gate.push(imu(0.12));
  EXPECT_EQ(passed(gate), "is");
}

TEST(ScanGate, ASensorThatFallsSilentHoldsNothingUpForLong) {
  ScanGate gate(true, false, 0.5);
  gate.push(scan(0, 0, 0.1F));
  for (int i = 1; i <= 6; ++i) gate.push(scan(0.1 * i, 0, 0.1F));
  EXPECT_EQ(passed(gate), "");
  gate.push(scan(0.7, 0, 0.1F));
  EXPECT_EQ(passed(gate), "s");  // the first alone is late enough
  gate.close();
  EXPECT_EQ(passed(gate), "sssssss");
}

TEST(ScanGate, AnEmptyScanIsNoTrouble) {
  ScanGate gate(true, false);
  auto empty = std::make_shared<Cloud>();
  empty->stamp = at(0);
  gate.push(empty);
  gate.push(odometry(0.01));
  EXPECT_EQ(passed(gate), "os");
}

}  // namespace
}  // namespace sgraph
