#include <gtest/gtest.h>

#include <boost/make_shared.hpp>

#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <random>

#include "sgraph_slam/ros/cloud_message.hpp"
#include "sgraph_slam/ros/shared_pointer.hpp"

namespace sgraph {
namespace {

using Field = sensor_msgs::PointField;

std::shared_ptr<Cloud> random_cloud(unsigned seed, int size) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<float> meters(-50, 50);
  auto cloud = std::make_shared<Cloud>();
  cloud->stamp = {1'700'000'000'123'456'789};
  cloud->frame = "velodyne";
  for (int i = 0; i < size; ++i) {
    Point p;
    p.x = meters(engine);
    p.y = meters(engine);
    p.z = meters(engine);
    p.intensity = static_cast<float>(i % 256);
    p.time = -0.1F + static_cast<float>(i) * 1e-5F;
    p.ring = static_cast<std::uint16_t>(i % 16);
    cloud->points.push_back(p);
  }
  return cloud;
}

/// What `To` reads from the bytes that `From` writes.
template <class To, class From>
To through_the_wire(const From& message) {
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream out(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(out, message);
  EXPECT_EQ(out.getLength(), 0U) << "announced length and written length differ";
  To result;
  ros::serialization::IStream in(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::deserialize(in, result);
  EXPECT_EQ(in.getLength(), 0U) << "not all bytes were read";
  return result;
}

void expect_same(const Cloud& a, const Cloud& b) {
  EXPECT_EQ(a.stamp, b.stamp);
  EXPECT_EQ(a.frame, b.frame);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.points[i].x, b.points[i].x);
    EXPECT_EQ(a.points[i].y, b.points[i].y);
    EXPECT_EQ(a.points[i].z, b.points[i].z);
    EXPECT_EQ(a.points[i].intensity, b.points[i].intensity);
    EXPECT_EQ(a.points[i].time, b.points[i].time);
    EXPECT_EQ(a.points[i].ring, b.points[i].ring);
  }
}

TEST(CloudMessage, ComesBackAsItWasSent) {
  for (const int size : {0, 1, 1000}) {
    const auto cloud = random_cloud(7, size);
    expect_same(through_the_wire<Cloud>(*cloud), *cloud);
  }
}

TEST(CloudMessage, IsAPointCloud2ToOthers) {
  const auto cloud = random_cloud(3, 100);
  const auto message = through_the_wire<sensor_msgs::PointCloud2>(*cloud);
  EXPECT_EQ(message.header.stamp.sec, 1'700'000'000U);
  EXPECT_EQ(message.header.stamp.nsec, 123'456'789U);
  EXPECT_EQ(message.header.frame_id, "velodyne");
  EXPECT_EQ(message.height, 1U);
  EXPECT_EQ(message.width, 100U);
  EXPECT_EQ(message.row_step, message.width * message.point_step);
  EXPECT_EQ(message.data.size(), message.row_step);
  EXPECT_TRUE(message.is_dense);
  EXPECT_FALSE(message.is_bigendian);

  std::vector<std::string> names;
  for (const Field& field : message.fields) {
    names.push_back(field.name);
    ASSERT_EQ(field.count, 1U);
    ASSERT_EQ(field.datatype, field.name == "ring" ? Field::UINT16 : Field::FLOAT32) << field.name;
    for (std::size_t i = 0; i < cloud->size(); ++i) {
      const std::uint8_t* at = &message.data[i * message.point_step + field.offset];
      const Point& p = cloud->points[i];
      if (field.name == "ring") {
        std::uint16_t ring = 0;
        std::memcpy(&ring, at, sizeof ring);
        EXPECT_EQ(ring, p.ring);
        continue;
      }
      float value = 0;
      std::memcpy(&value, at, sizeof value);
      const std::map<std::string, float> expected{{"x", p.x}, {"y", p.y}, {"z", p.z}, {"intensity", p.intensity}, {"time", p.time}};
      EXPECT_EQ(value, expected.at(field.name)) << field.name;
    }
  }
  EXPECT_EQ(names, (std::vector<std::string>{"x", "y", "z", "intensity", "time", "ring"}));
}

TEST(CloudMessage, SaysWhenPointsAreNotFinite) {
  auto cloud = random_cloud(3, 5);
  cloud->points[2].y = std::nanf("");
  EXPECT_FALSE(through_the_wire<sensor_msgs::PointCloud2>(*cloud).is_dense);
}

TEST(CloudMessage, HasTheIdentityOfPointCloud2) {
  namespace traits = ros::message_traits;
  EXPECT_STREQ(traits::md5sum<Cloud>(), traits::md5sum<sensor_msgs::PointCloud2>());
  EXPECT_STREQ(traits::datatype<const Cloud>(), "sensor_msgs/PointCloud2");
  EXPECT_STREQ(traits::definition<Cloud>(), traits::definition<sensor_msgs::PointCloud2>());
}

TEST(CloudMessage, ReadsAnotherLayoutByName) {
  // ring, then y x z as PCL would never lay them out, 3 bytes of padding
  sensor_msgs::PointCloud2 message;
  message.header.stamp = ros::Time(5, 6);
  message.header.frame_id = "other";
  message.height = 1;
  message.width = 2;
  message.point_step = 17;
  message.row_step = 34;
  message.data.resize(34);
  const auto add = [&message](const char* name, std::uint32_t offset, std::uint8_t type) {
    Field field;
    field.name = name;
    field.offset = offset;
    field.datatype = type;
    field.count = 1;
    message.fields.push_back(field);
  };
  add("ring", 0, Field::UINT16);
  add("y", 2, Field::FLOAT32);
  add("x", 6, Field::FLOAT32);
  add("z", 10, Field::FLOAT32);
  for (std::uint16_t i = 0; i < 2; ++i) {
    const std::array<float, 3> yxz{2.F + i, 1.F + i, 3.F + i};
    std::memcpy(&message.data[17U * i], &i, 2);
    std::memcpy(&message.data[17U * i + 2], yxz.data(), 12);
  }
  const auto cloud = through_the_wire<Cloud>(message);
  ASSERT_EQ(cloud.size(), 2U);
  EXPECT_EQ(cloud.stamp.nanoseconds, 5'000'000'006);
  EXPECT_EQ(cloud.points[1].position(), Eigen::Vector3f(2, 3, 4));
  EXPECT_EQ(cloud.points[1].ring, 1);
  EXPECT_EQ(cloud.points[1].time, 0);
}

TEST(CloudMessage, RefusesACloudWithoutPositions) {
  sensor_msgs::PointCloud2 message;
  message.height = message.width = 1;
  message.point_step = message.row_step = 4;
  message.data.resize(4);
  Field field;
  field.name = "intensity";
  field.datatype = Field::FLOAT32;
  field.count = 1;
  message.fields.push_back(field);
  std::vector<std::uint8_t> bytes(ros::serialization::serializationLength(message));
  ros::serialization::OStream out(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  ros::serialization::serialize(out, message);
  ros::serialization::IStream in(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
  Cloud cloud;
  EXPECT_THROW(ros::serialization::deserialize(in, cloud), std::runtime_error);
}

TEST(SharedPointer, GoesThereAndBackWithoutACopy) {
  const CloudPtr original = random_cloud(1, 10);
  const CloudMessage message = to_boost(original);
  EXPECT_EQ(message.get(), original.get());
  const CloudPtr back = to_std(message);
  EXPECT_FALSE(back.owner_before(original) || original.owner_before(back)) << "another owner: the way back wrapped the pointer again";
  EXPECT_EQ(back, original);
}

TEST(SharedPointer, KeepsTheObjectAlive) {
  std::weak_ptr<const Cloud> watch;
  CloudMessage message;
  {
    const CloudPtr original = random_cloud(1, 10);
    watch = original;
    message = to_boost(original);
  }
  EXPECT_FALSE(watch.expired());
  message.reset();
  EXPECT_TRUE(watch.expired());
}

TEST(SharedPointer, TakesAForeignBoostPointer) {
  auto foreign = boost::make_shared<const Cloud>(*random_cloud(1, 10));
  CloudPtr kept = to_std(foreign);
  EXPECT_EQ(kept.get(), foreign.get());
  EXPECT_EQ(to_boost(kept), foreign);
  const Cloud* address = foreign.get();
  foreign.reset();
  EXPECT_EQ(kept.get(), address);
  EXPECT_EQ(kept->size(), 10U);
}

TEST(SharedPointer, IsNotFooledByAnAlias) {
  struct Pair {
    Cloud first;
    Cloud second;
  };
  const auto pair = std::make_shared<Pair>();
  const CloudPtr second(pair, &pair->second);
  EXPECT_EQ(to_boost(second).get(), &pair->second);
  EXPECT_EQ(to_std(to_boost(second)), second);
}

}  // namespace
}  // namespace sgraph
