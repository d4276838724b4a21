#include "sgraph_slam/core/pipeline/scan_gate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
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

// A clock that is wrong once, and one that stood still: after the first, none of the scans that follow is late.
TEST(ScanGate, AScanFarAheadPassesOnlyWhenTheNextOneAgrees) {
  for (const bool wait : {false, true}) {
    ScanGate gate(wait, false);
    const auto push = [&](double stamp) {
      gate.push(scan(stamp, 0, 0));
      if (wait && stamp < 1000) gate.push(odometry(stamp));
    };
    std::string scans;
    const auto take = [&] {
      const std::string text = passed(gate);
      scans += std::string(static_cast<std::size_t>(std::count(text.begin(), text.end(), 's')), 's');
    };
    push(0), take();
    push(1e6), take();
    EXPECT_EQ(scans, "s");
    push(0.1), take();
    EXPECT_EQ(scans, "ss");
    const auto dropped = gate.take_dropped();
    ASSERT_TRUE(dropped);
    EXPECT_EQ((*dropped)->stamp, at(1e6));
    EXPECT_FALSE(gate.take_dropped());
    push(0.2), take();
    push(60), take();
    EXPECT_EQ(scans, "sss") << "a pause, or a wrong stamp";
    push(60.1), take();
    EXPECT_EQ(scans, "sssss") << "a pause";
    EXPECT_FALSE(gate.take_dropped());
    push(500), take();
    gate.close();
    take();
    EXPECT_EQ(scans, "ssssss") << "at the recording's end nothing speaks against it";
  }
}

}  // namespace
}  // namespace sgraph
