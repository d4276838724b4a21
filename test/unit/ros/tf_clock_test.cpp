#include "sgraph_slam/ros/tf_clock.hpp"

#include <gtest/gtest.h>

namespace sgraph {
namespace {

TEST(TfClock, SaysNothingBeforeTheFirstOdometry) {
  TfClock clock(ros::Duration(0.1));
  EXPECT_FALSE(clock.stamp(ros::Time(100)));
}

TEST(TfClock, IsALittleAheadOfRosTime) {
  TfClock clock(ros::Duration(0.1));
  clock.heard(ros::Time(99.85), ros::Time(100));
  EXPECT_EQ(clock.stamp(ros::Time(100)), ros::Time(100.1));
  EXPECT_EQ(clock.stamp(ros::Time(100.05)), ros::Time(100.15));  // goes on without news
  EXPECT_EQ(clock.stamp(ros::Time(130)), ros::Time(130.1));
}

TEST(TfClock, NeverRepeatsAStamp) {
  TfClock clock(ros::Duration(0.1));
  clock.heard(ros::Time(99.9), ros::Time(100));
  EXPECT_TRUE(clock.stamp(ros::Time(100)));
  EXPECT_FALSE(clock.stamp(ros::Time(100)));  // simulated time stands still
}

TEST(TfClock, FollowsDataThatRunsOnAnotherClock) {
  TfClock clock(ros::Duration(0.1));
  const std::uint32_t present = 1'700'000'000;
  clock.heard(ros::Time(50, 0), ros::Time(present, 0));
  EXPECT_EQ(clock.stamp(ros::Time(present, 0)), ros::Time(50, 100'000'000));
  EXPECT_EQ(clock.stamp(ros::Time(present, 500'000'000)), ros::Time(50, 600'000'000));
  clock.heard(ros::Time(50, 50'000'000), ros::Time(present, 600'000'000));  // came late: the stamps don't go back
  EXPECT_FALSE(clock.stamp(ros::Time(present, 600'000'000)));
  EXPECT_EQ(clock.stamp(ros::Time(present + 1, 500'000'000)), ros::Time(51, 50'000'000));
}

TEST(TfClock, GoesBackWhenTimeDoes) {
  TfClock clock(ros::Duration(0.1));
  clock.heard(ros::Time(200), ros::Time(200));
  EXPECT_EQ(clock.stamp(ros::Time(200)), ros::Time(200.1));
  clock.heard(ros::Time(10), ros::Time(10));  // the bag starts again
  EXPECT_EQ(clock.stamp(ros::Time(10)), ros::Time(10.1));
  EXPECT_EQ(clock.stamp(ros::Time(10.05)), ros::Time(10.15));
}

TEST(TfClock, WorksAtTheBeginningOfSimulatedTime) {
  TfClock clock(ros::Duration(0.1));
  clock.heard(ros::Time(0), ros::Time(0));
  EXPECT_EQ(clock.stamp(ros::Time(0)), ros::Time(0.1));
  clock.heard(ros::Time(0.5), ros::Time(1000));
  EXPECT_NO_THROW(clock.stamp(ros::Time(10)));  // the data's clock would be below zero, which ros::Time can't hold
}

}  // namespace
}  // namespace sgraph
