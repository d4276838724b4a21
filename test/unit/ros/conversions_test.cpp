#include "sgraph_slam/ros/conversions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace sgraph {
namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;
using testing::HasSubstr;

// Builds clouds of any layout, value by value.
class CloudBuilder {
 public:
  explicit CloudBuilder(std::uint32_t width, std::uint32_t height = 1, std::uint32_t padding = 0) {
    message_.header.stamp = ros::Time(1'700'000'000, 123'456'789);
    message_.header.frame_id = "/velodyne";
    message_.width = width;
    message_.height = height;
    message_.point_step = padding;
    layout();
  }

  template <class T>
  CloudBuilder& field(const char* name, std::uint8_t datatype, const std::vector<T>& values) {
    const std::uint32_t old_step = message_.point_step;
    const std::vector<std::uint8_t> old = message_.data;
    PointField field;
    field.name = name;
    field.offset = old_step;
    field.datatype = datatype;
    field.count = 1;
    message_.fields.push_back(field);
    message_.point_step += static_cast<std::uint32_t>(sizeof(T));
    layout();
    for (std::size_t i = 0; i < std::size_t{message_.width} * message_.height; ++i) {
      std::copy_n(old.begin() + static_cast<std::ptrdiff_t>(at(i, old_step)), old_step,
                  message_.data.begin() + static_cast<std::ptrdiff_t>(at(i, message_.point_step)));
      std::memcpy(message_.data.data() + at(i, message_.point_step) + old_step, &values[i % values.size()], sizeof(T));
    }
    return *this;
  }
  CloudBuilder& xyz() {
    return field<float>("x", PointField::FLOAT32, {1, 2, 3, 4})
        .field<float>("y", PointField::FLOAT32, {5, 6, 7, 8})
        .field<float>("z", PointField::FLOAT32, {9});
  }

  PointCloud2 message_;

 private:
  static constexpr std::uint32_t row_padding = 5;  // rows need not be tight
  void layout() {
    message_.row_step = message_.width * message_.point_step + row_padding;
    message_.data.assign(std::size_t{message_.row_step} * message_.height, 0xAB);
  }
  [[nodiscard]] std::size_t at(std::size_t i, std::uint32_t step) const {
    return i / message_.width * (message_.width * step + row_padding) + i % message_.width * step;
  }
};

TEST(CloudConversion, VelodyneLayout) {
  CloudBuilder builder(4);
  builder.xyz().field<float>("intensity", PointField::FLOAT32, {10, 20, 30, 40});
  builder.field<std::uint16_t>("ring", PointField::UINT16, {0, 5, 15, 300}).field<float>("time", PointField::FLOAT32, {-0.1F, 0, 0.05F, 0.1F});
  const auto cloud = to_cloud(builder.message_);
  ASSERT_TRUE(cloud) << cloud.text;
  EXPECT_EQ(cloud.value->stamp.nanoseconds, 1'700'000'000'123'456'789);
  EXPECT_EQ(cloud.value->frame, "velodyne");
  ASSERT_EQ(cloud.value->size(), 4U);
  const Point& p = cloud.value->points[3];
  EXPECT_EQ(p.position(), Eigen::Vector3f(4, 8, 9));
  EXPECT_EQ(p.intensity, 40);
  EXPECT_EQ(p.ring, 300);
  EXPECT_FLOAT_EQ(p.time, 0.1F);
  EXPECT_FLOAT_EQ(cloud.value->points[0].time, -0.1F);
}

// The layout is that of each message, not that of the first one seen.
TEST(CloudConversion, TwoLayoutsOneAfterTheOther) {
  CloudBuilder packed(4);
  packed.xyz().field<std::uint16_t>("ring", PointField::UINT16, {7});
  CloudBuilder spaced(4, 1, 3);
  spaced.field<std::uint8_t>("ring", PointField::UINT8, {9}).field<double>("unknown", PointField::FLOAT64, {1e9}).xyz();
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(to_cloud(packed.message_).value->points[2].ring, 7);
    const auto cloud = to_cloud(spaced.message_);
    ASSERT_TRUE(cloud) << cloud.text;
    EXPECT_EQ(cloud.value->points[2].ring, 9);
    EXPECT_EQ(cloud.value->points[2].position(), Eigen::Vector3f(3, 7, 9));
  }
}

TEST(CloudConversion, OusterLayout) {
  CloudBuilder builder(2, 2);
  builder.xyz()
      .field<std::uint32_t>("t", PointField::UINT32, {0, 1'000, 50'000'000, 99'999'999})
      .field<std::uint8_t>("ring", PointField::UINT8, {127});
  builder.field<std::uint16_t>("intensity", PointField::UINT16, {60000});
  const auto cloud = to_cloud(builder.message_);
  ASSERT_TRUE(cloud) << cloud.text;
  ASSERT_EQ(cloud.value->size(), 4U);
  EXPECT_EQ(cloud.value->points[2].position(), Eigen::Vector3f(3, 7, 9));  // second row
  EXPECT_FLOAT_EQ(cloud.value->points[1].time, 1e-6F);
  EXPECT_FLOAT_EQ(cloud.value->points[3].time, 0.099999999F);
  EXPECT_EQ(cloud.value->points[3].ring, 127);
  EXPECT_EQ(cloud.value->points[0].intensity, 60000);
}

TEST(CloudConversion, AbsoluteTimesOfHesaiAndRoboSense) {
  const double stamp = 1'700'000'000.123456789;
  for (const double unit : {1.0, 1e9}) {  // seconds, and the nanoseconds of some drivers
    CloudBuilder builder(4);
    builder.xyz().field<double>("timestamp", PointField::FLOAT64, {unit * (stamp - 0.1), unit * stamp, unit * (stamp + 0.05), 0});
    const auto cloud = to_cloud(builder.message_);
    ASSERT_TRUE(cloud) << cloud.text;
    EXPECT_NEAR(cloud.value->points[0].time, -0.1, 1e-6);
    EXPECT_NEAR(cloud.value->points[1].time, 0, 1e-6);
    EXPECT_NEAR(cloud.value->points[2].time, 0.05, 1e-6);
    EXPECT_EQ(cloud.value->points[3].time, 0);  // no return
  }
}

TEST(CloudConversion, DoublesAreTakenAndMissingFieldsAreZero) {
  CloudBuilder builder(3);
  builder.field<double>("z", PointField::FLOAT64, {3.5})
      .field<double>("x", PointField::FLOAT64, {1.5})
      .field<float>("y", PointField::FLOAT32, {2.5F});
  const auto cloud = to_cloud(builder.message_);
  ASSERT_TRUE(cloud) << cloud.text;
  for (const Point& p : cloud.value->points) {
    EXPECT_EQ(p.position(), Eigen::Vector3f(1.5F, 2.5F, 3.5F));
    EXPECT_EQ(p.intensity, 0);
    EXPECT_EQ(p.time, 0);
    EXPECT_EQ(p.ring, 0);
  }
}

TEST(CloudConversion, NotANumberIsKept) {
  CloudBuilder builder(2);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  builder.field<float>("x", PointField::FLOAT32, {nan, 1})
      .field<float>("y", PointField::FLOAT32, {nan, 1})
      .field<float>("z", PointField::FLOAT32, {nan, 1});
  builder.field<float>("time", PointField::FLOAT32, {nan, 0.01F});
  const auto cloud = to_cloud(builder.message_);
  ASSERT_TRUE(cloud) << cloud.text;
  ASSERT_EQ(cloud.value->size(), 2U);
  EXPECT_TRUE(std::isnan(cloud.value->points[0].x));
  EXPECT_EQ(cloud.value->points[0].time, 0);
}

TEST(CloudConversion, AnEmptyCloudIsACloud) {
  CloudBuilder builder(0);
  builder.xyz();
  const auto cloud = to_cloud(builder.message_);
  ASSERT_TRUE(cloud) << cloud.text;
  EXPECT_TRUE(cloud.value->empty());
}

TEST(CloudConversion, WhatCannotBeReadIsRefusedWithAReason) {
  const auto expect = [](const PointCloud2& message, MessageFault fault, const char* words) {
    const auto cloud = to_cloud(message);
    EXPECT_EQ(cloud.fault, fault) << words;
    EXPECT_EQ(cloud.value, nullptr);
    EXPECT_THAT(cloud.text, HasSubstr(words));
  };
  expect(PointCloud2(), MessageFault::missing_field, "no field x (fields: none)");
  CloudBuilder flat(2);
  flat.field<float>("x", PointField::FLOAT32, {1}).field<float>("y", PointField::FLOAT32, {1});
  expect(flat.message_, MessageFault::missing_field, "no field z (fields: x y)");
  CloudBuilder whole(2);
  whole.xyz().message_.fields[1].datatype = PointField::INT32;
  expect(whole.message_, MessageFault::field_type, "field y is neither");
  CloudBuilder ring(2);
  ring.xyz().field<float>("ring", PointField::FLOAT32, {1});
  expect(ring.message_, MessageFault::field_type, "field ring");
  CloudBuilder unknown(2);
  unknown.xyz().field<float>("extra", 77, {1});
  expect(unknown.message_, MessageFault::field_type, "unknown type 77");
  CloudBuilder none(2);
  none.xyz().field<float>("t", 77, {1}).message_.fields.back().count = 0;  // as some drivers say of padding; but this one is read
  expect(none.message_, MessageFault::field_type, "unknown type 77");
  CloudBuilder big(2);
  big.xyz().message_.is_bigendian = 1;
  expect(big.message_, MessageFault::big_endian, "big-endian");
  CloudBuilder far(2);
  far.xyz().field<double>("timestamp", PointField::FLOAT64, {12.5});
  expect(far.message_, MessageFault::times, "another unit or clock");
}

TEST(CloudConversion, ContradictingSizesAreRefused) {
  const auto fault_of = [](auto&& change) {
    CloudBuilder builder(4, 3);
    builder.xyz();
    change(builder.message_);
    return to_cloud(builder.message_).fault;
  };
  EXPECT_EQ(fault_of([](PointCloud2&) {}), MessageFault::none);
  EXPECT_EQ(fault_of([](PointCloud2& m) { m.data.pop_back(); }), MessageFault::layout);
  EXPECT_EQ(fault_of([](PointCloud2& m) { m.row_step = 0; }), MessageFault::layout);
  EXPECT_EQ(fault_of([](PointCloud2& m) { m.row_step = 4 * 12 - 1; }), MessageFault::layout);
  EXPECT_EQ(fault_of([](PointCloud2& m) { m.width = 0xFFFFFFFF; }), MessageFault::layout);
  EXPECT_EQ(fault_of([](PointCloud2& m) { m.height = 0xFFFFFFFF; }), MessageFault::layout);
  EXPECT_EQ(fault_of([](PointCloud2& m) { m.point_step = 11; }), MessageFault::layout);
  EXPECT_EQ(fault_of([](PointCloud2& m) { m.fields[2].offset = 9; }), MessageFault::layout);
  EXPECT_EQ(fault_of([](PointCloud2& m) { m.fields[2].offset = 0xFFFFFFFE; }), MessageFault::layout);
  EXPECT_EQ(fault_of([](PointCloud2& m) { m.data.clear(); }), MessageFault::layout);
}

// Whatever the header says, reading stays inside the data (the sanitizers watch).
TEST(CloudConversion, DamagedHeadersNeverReadOutside) {
  std::mt19937 random(17);
  int taken = 0;
  for (int i = 0; i < 5000; ++i) {
    CloudBuilder builder(8, 2);
    builder.xyz().field<std::uint16_t>("ring", PointField::UINT16, {3}).field<float>("time", PointField::FLOAT32, {0});
    PointCloud2& m = builder.message_;
    const auto small = [&random] { return static_cast<std::uint32_t>(random() % 40); };
    if (random() % 3 == 0) m.width = small();
    if (random() % 3 == 0) m.height = small();
    if (random() % 3 == 0) m.point_step = small();
    if (random() % 3 == 0) m.row_step = 8 * small();
    if (random() % 3 == 0) m.fields[random() % m.fields.size()].offset = small();
    if (random() % 3 == 0) m.fields[random() % m.fields.size()].datatype = static_cast<std::uint8_t>(small() % 10);
    const auto cloud = to_cloud(m);
    EXPECT_EQ(cloud.value != nullptr, cloud.fault == MessageFault::none);
    taken += cloud ? 1 : 0;
  }
  EXPECT_GT(taken, 100);
  EXPECT_LT(taken, 4900);
}

TEST(StampConversion, IsExactBothWays) {
  for (const ros::Time& time : {ros::Time(0, 1), ros::Time(1'700'000'000, 999'999'999), ros::Time(4'294'967'295U, 123'456'789)}) {
    EXPECT_EQ(to_ros_time(to_stamp(time)), time);
  }
  EXPECT_EQ(to_stamp(ros::Time(3, 5)).nanoseconds, 3'000'000'005);
}

TEST(OdometryConversion, CovarianceIsReordered) {
  nav_msgs::Odometry message;
  message.header.stamp = ros::Time(10, 20);
  message.pose.pose.position.x = 1;
  message.pose.pose.position.z = -2;
  message.pose.pose.orientation.z = std::sqrt(0.5);
  message.pose.pose.orientation.w = std::sqrt(0.5);
  for (std::size_t row = 0; row < 6; ++row) {
    for (std::size_t column = 0; column < 6; ++column)
      message.pose.covariance[6 * row + column] = static_cast<double>(10 * std::min(row, column) + std::max(row, column));
  }
  const auto sample = to_odometry_sample(message);
  ASSERT_TRUE(sample) << sample.text;
  EXPECT_EQ(sample.value.stamp.nanoseconds, 10'000'000'020);
  EXPECT_EQ(sample.value.T_odom_base.translation, Eigen::Vector3d(1, 0, -2));
  EXPECT_LT((sample.value.T_odom_base * Eigen::Vector3d::UnitX() - Eigen::Vector3d(1, 1, -2)).norm(), 1e-12);
  const Matrix6& c = sample.value.covariance;
  EXPECT_EQ(c(0, 0), 33);  // rotation about x is the fourth of ROS
  EXPECT_EQ(c(2, 2), 55);
  EXPECT_EQ(c(3, 3), 0);
  EXPECT_EQ(c(4, 4), 11);
  EXPECT_EQ(c(0, 4), 13);  // rotation about x with translation along y
  EXPECT_EQ(c(4, 0), 13);
  EXPECT_EQ(c(1, 2), 45);
}

TEST(OdometryConversion, BrokenPosesAreRefusedAndBrokenCovariancesIgnored) {
  nav_msgs::Odometry message;
  EXPECT_EQ(to_odometry_sample(message).fault, MessageFault::quaternion);  // all zero
  message.pose.pose.orientation.w = 1.0005;
  ASSERT_TRUE(to_odometry_sample(message));
  EXPECT_DOUBLE_EQ(to_odometry_sample(message).value.T_odom_base.rotation.norm(), 1);
  message.pose.covariance[0] = -1;
  message.pose.covariance[7] = 1;
  EXPECT_TRUE(to_odometry_sample(message).value.covariance.isZero());
  message.pose.pose.position.y = std::numeric_limits<double>::infinity();
  EXPECT_EQ(to_odometry_sample(message).fault, MessageFault::not_finite);
}

TEST(ImuConversion, ReadingsAreTurnedIntoTheBase) {
  sensor_msgs::Imu message;
  message.angular_velocity.x = 1;
  message.linear_acceleration.z = 9.81;
  const Eigen::Quaterniond upside_down(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
  const auto sample = to_imu_sample(message, upside_down);
  ASSERT_TRUE(sample);
  EXPECT_LT((sample.value.angular_velocity - Eigen::Vector3d(1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((sample.value.linear_acceleration - Eigen::Vector3d(0, 0, -9.81)).norm(), 1e-12);
  message.angular_velocity.y = std::nan("");
  EXPECT_EQ(to_imu_sample(message, upside_down).fault, MessageFault::not_finite);
}

}  // namespace
}  // namespace sgraph
