#include "sgraph_slam/ros/bag_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <tf2_msgs/TFMessage.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace sgraph {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

constexpr std::uint32_t t0 = 1'700'000'000;

ros::Time at(double seconds) { return ros::Time(t0) + ros::Duration(seconds); }

sensor_msgs::PointCloud2 cloud(double stamp, const std::string& frame = "velodyne") {
  sensor_msgs::PointCloud2 message;
  message.header.stamp = at(stamp);
  message.header.frame_id = frame;
  message.height = 1;
  message.width = 10;
  for (const char* name : {"x", "y", "z"}) {
    sensor_msgs::PointField field;
    field.name = name;
    field.offset = static_cast<std::uint32_t>(4 * message.fields.size());
    field.datatype = sensor_msgs::PointField::FLOAT32;
    field.count = 1;
    message.fields.push_back(field);
  }
  message.point_step = 12;
  message.row_step = 120;
  message.data.resize(120);
  return message;
}

nav_msgs::Odometry odometry(double stamp, double x, const std::string& child = "base_link") {
  nav_msgs::Odometry message;
  message.header.stamp = at(stamp);
  message.header.frame_id = "odom";
  message.child_frame_id = child;
  message.pose.pose.position.x = x;
  message.pose.pose.orientation.z = std::sqrt(0.5);
  message.pose.pose.orientation.w = std::sqrt(0.5);
  return message;
}

geometry_msgs::TransformStamped transform(const std::string& parent, const std::string& child, double x, double z, double yaw) {
  geometry_msgs::TransformStamped message;
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform.translation.x = x;
  message.transform.translation.z = z;
  message.transform.rotation.z = std::sin(yaw / 2);
  message.transform.rotation.w = std::cos(yaw / 2);
  return message;
}

class BagSourceTest : public testing::Test {
 protected:
  BagSourceTest() : folder_(fs::temp_directory_path() / ("bag_source_test." + std::to_string(getpid()))) { fs::create_directories(folder_); }
  ~BagSourceTest() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  // Ten scans at 10 Hz, each recorded 5 ms after its stamp.
  static void write_scans(rosbag::Bag& bag, double from = 0, const std::string& frame = "velodyne") {
    for (int i = 0; i < 10; ++i) bag.write("/velodyne_points", at(from + 0.1 * i + 0.005), cloud(from + 0.1 * i, frame));
  }
  static void write_static(rosbag::Bag& bag, const std::vector<geometry_msgs::TransformStamped>& transforms) {
    for (const auto& one : transforms) {
      tf2_msgs::TFMessage message;
      message.transforms.push_back(one);
      bag.write("/tf_static", at(0), message);
    }
  }
  std::string plain(const std::string& name = "plain.bag", rosbag::CompressionType compression = rosbag::compression::Uncompressed) const {
    rosbag::Bag bag(path(name), rosbag::bagmode::Write);
    bag.setCompression(compression);
    write_static(bag, {transform("base_link", "velodyne", 0.1, 0.25, 0)});
    write_scans(bag);
    return path(name);
  }
  static BagOptions options(const std::string& file) {
    BagOptions options;
    options.bags = {file};
    return options;
  }
  static std::string error_of(const BagOptions& options) {
    try {
      BagSource source(options);
      while (source.next()) {
      }
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      return error.what();
    }
    return "";
  }
  static std::vector<SensorEvent> all(SensorSource& source) {
    std::vector<SensorEvent> events;
    while (auto event = source.next()) events.push_back(*event);
    return events;
  }

  fs::path folder_;
};

TEST_F(BagSourceTest, ScansComeInOrderWithExactStamps) {
  BagSource source(options(plain()));
  EXPECT_EQ(source.scan_count(), 10);
  EXPECT_EQ(source.lidar_frame(), "velodyne");
  EXPECT_LT((source.T_base_lidar().translation - Eigen::Vector3d(0.1, 0, 0.25)).norm(), 1e-12);
  const auto events = all(source);
  ASSERT_EQ(events.size(), 10U);
  for (int i = 0; i < 10; ++i) {
    const CloudPtr scan = std::get<CloudPtr>(events[static_cast<std::size_t>(i)]);
    EXPECT_EQ(scan->stamp.nanoseconds, std::int64_t{t0} * 1'000'000'000 + i * 100'000'000);
    EXPECT_EQ(scan->size(), 10U);
  }
}

TEST_F(BagSourceTest, CompressedBagsReadTheSame) {
  for (const auto compression : {rosbag::compression::LZ4, rosbag::compression::BZ2}) {
    BagSource source(options(plain("compressed.bag", compression)));
    EXPECT_EQ(all(source).size(), 10U);
  }
}

TEST_F(BagSourceTest, TransformsAreChained) {
  const std::string file = path("chain.bag");
  {
    rosbag::Bag bag(file, rosbag::bagmode::Write);
    write_static(bag,
                 {transform("base_link", "mast", 1, 0, M_PI / 2), transform("mast", "head", 2, 0.5, 0), transform("head", "/velodyne", 0, 0, M_PI)});
    write_scans(bag, 0, "/velodyne");
  }
  BagSource source(options(file));
  // base -> mast: 1 m ahead, turned left; mast -> head: 2 m along the mast's x, which is the base's y; the LiDAR is the head turned round.
  EXPECT_LT((source.T_base_lidar() * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 1, 0.5)).norm(), 1e-9);
}

TEST_F(BagSourceTest, AMissingTransformIsNamedAndNeverTheIdentity) {
  const std::string file = path("missing.bag");
  {
    rosbag::Bag bag(file, rosbag::bagmode::Write);
    write_static(bag, {transform("base_link", "camera", 1, 0, 0)});
    write_scans(bag);
  }
  EXPECT_THAT(error_of(options(file)),
              AllOf(HasSubstr("no transform from velodyne to base_link"), HasSubstr("base_link -> camera"), HasSubstr("--base-to-lidar")));

  BagOptions given = options(file);
  given.T_base_lidar = Pose{Eigen::Quaterniond::Identity(), {0, 0, 2}};
  EXPECT_EQ(BagSource(given).T_base_lidar().translation.z(), 2);

  BagOptions lidar_is_base = options(file);
  lidar_is_base.base_frame = "velodyne";
  EXPECT_TRUE(BagSource(lidar_is_base).T_base_lidar().translation.isZero());
}

TEST_F(BagSourceTest, OdometryComesBeforeTheScansItCovers) {
  const std::string file = path("odometry.bag");
  {
    rosbag::Bag bag(file, rosbag::bagmode::Write);
    write_static(bag, {transform("base_link", "velodyne", 0.1, 0.25, 0)});
    write_scans(bag);
    for (int i = 0; i <= 50; ++i) bag.write("/odom", at(0.02 * i + 0.03), odometry(0.02 * i, i));  // late
  }
  BagOptions with_odometry = options(file);
  with_odometry.odom_topic = "/odom";
  BagSource source(with_odometry);
  Stamp newest;
  int scans = 0;
  for (const SensorEvent& event : all(source)) {
    if (const auto* sample = std::get_if<OdometrySample>(&event)) {
      newest = sample->stamp;
    } else {
      EXPECT_GE(newest, std::get<CloudPtr>(event)->stamp);
      ++scans;
    }
  }
  EXPECT_EQ(scans, 10);
}

TEST_F(BagSourceTest, OdometryOfAnotherFrameIsMovedToTheBase) {
  const std::string file = path("lidar_odometry.bag");
  {
    rosbag::Bag bag(file, rosbag::bagmode::Write);
    write_static(bag, {transform("base_link", "velodyne", 0.1, 0.25, 0)});
    write_scans(bag);
    bag.write("/lio", at(0.5), odometry(0.5, 3, "velodyne"));
  }
  BagOptions with_odometry = options(file);
  with_odometry.odom_topic = "/lio";
  BagSource source(with_odometry);
  int samples = 0;
  for (const SensorEvent& event : all(source)) {
    if (const auto* sample = std::get_if<OdometrySample>(&event)) {
      ++samples;
      // The LiDAR is at x = 3 and looks along y, so the base is 0.1 m behind it in y and 0.25 m below.
      EXPECT_LT((sample->T_odom_base.translation - Eigen::Vector3d(3, -0.1, -0.25)).norm(), 1e-9);
    }
  }
  EXPECT_EQ(samples, 1);

  rosbag::Bag(file, rosbag::bagmode::Append).write("/lio", at(0.6), odometry(0.6, 3, "gimbal"));
  BagSource mixed(with_odometry);
  all(mixed);
  EXPECT_EQ(mixed.readings_dropped().at("/lio frame"), 1);
}

TEST_F(BagSourceTest, StartAndDurationSelect) {
  BagOptions part = options(plain());
  part.start = 0.25;
  part.duration = 0.4;
  BagSource source(part);
  EXPECT_EQ(source.scan_count(), 4);
  EXPECT_EQ(std::get<CloudPtr>(*source.next())->stamp, to_stamp(at(0.3)));
  part.start = 100;
  EXPECT_THAT(error_of(part), HasSubstr("no scan on /velodyne_points within the chosen time"));
}

TEST_F(BagSourceTest, SeveralBagsAreOneRecording) {
  BagOptions both = options(plain());
  {
    rosbag::Bag bag(path("second.bag"), rosbag::bagmode::Write);
    write_scans(bag, 1.0);
  }
  both.bags.insert(both.bags.begin(), path("second.bag"));  // their times decide, not the order of the arguments
  BagSource source(both);
  EXPECT_EQ(source.scan_count(), 20);
  Stamp last;
  for (const SensorEvent& event : all(source)) {
    EXPECT_GT(std::get<CloudPtr>(event)->stamp, last);
    last = std::get<CloudPtr>(event)->stamp;
  }
}

TEST_F(BagSourceTest, BadFilesAreToldApart) {
  EXPECT_THAT(error_of(options(path("nowhere.bag"))), HasSubstr("there is no such file"));
  EXPECT_THAT(error_of(options(folder_.string())), HasSubstr("is a folder"));
  std::ofstream(path("zero.bag")).close();
  EXPECT_THAT(error_of(options(path("zero.bag"))), HasSubstr("the file is empty"));
  std::ofstream(path("text.bag")) << "this is not a bag at all\n";
  EXPECT_THAT(error_of(options(path("text.bag"))), HasSubstr("is not a ROS bag"));
  rosbag::Bag(path("no_messages.bag"), rosbag::bagmode::Write).close();
  EXPECT_THAT(error_of(options(path("no_messages.bag"))), HasSubstr("holds no messages"));
}

TEST_F(BagSourceTest, ATruncatedBagIsAlwaysOneClearLine) {
  const std::string whole = plain();
  const auto size = fs::file_size(whole);
  const std::string file = path("cut.bag");
  for (const double share : {0.1, 0.5, 0.9, 0.99}) {
    fs::copy_file(whole, file, fs::copy_options::overwrite_existing);
    fs::resize_file(file, static_cast<std::uintmax_t>(share * static_cast<double>(size)));
    EXPECT_THAT(error_of(options(file)), AllOf(HasSubstr("truncated"), HasSubstr("reindex"))) << share;
  }
}

TEST_F(BagSourceTest, TopicsThatAreMissingOrOfAnotherTypeAreNamedWithThoseThere) {
  const std::string file = plain();
  rosbag::Bag(file, rosbag::bagmode::Append).write("/odom", at(0), odometry(0, 0));
  BagOptions wrong = options(file);
  wrong.points_topic = "/points";
  EXPECT_THAT(error_of(wrong), AllOf(HasSubstr("no topic /points"),
                                     HasSubstr("topics of type sensor_msgs/PointCloud2 or velodyne_msgs/VelodyneScan: /velodyne_points;"),
                                     HasSubstr("/odom (nav_msgs/Odometry)")));
  wrong.points_topic = "/odom";
  EXPECT_THAT(error_of(wrong), HasSubstr("topic /odom is a nav_msgs/Odometry"));
  wrong = options(file);
  wrong.imu_topic = "/imu";
  EXPECT_THAT(error_of(wrong), AllOf(HasSubstr("no topic /imu"), HasSubstr("sensor_msgs/Imu: none")));
}

TEST_F(BagSourceTest, CloudsThatCannotBeUsed) {
  const std::string file = path("broken.bag");
  auto broken = cloud(0.2);
  broken.fields[2].name = "height";
  {
    rosbag::Bag bag(file, rosbag::bagmode::Write);
    bag.write("/velodyne_points", at(0), cloud(0));
    bag.write("/velodyne_points", at(0.2), broken);
    bag.write("/velodyne_points", at(0.3), cloud(0.3));
    bag.write("/broken", at(0.2), broken);
  }
  // Among good ones it is left out and counted.
  BagOptions chosen = options(file);
  chosen.points_topic = "/velodyne_points";
  chosen.base_frame = "velodyne";
  BagSource source(chosen);
  EXPECT_EQ(all(source).size(), 2U);
  EXPECT_EQ(source.dropped().at(MessageFault::missing_field), 1);
  // A recording that begins with one is not usable.
  chosen.points_topic = "/broken";
  EXPECT_THAT(error_of(chosen), AllOf(HasSubstr("/broken"), HasSubstr("no field z")));
}

TEST_F(BagSourceTest, ASecondLidarOnTheTopicIsRefused) {
  const std::string file = plain();
  // One scan of another frame is left out (test Faults); a second LiDAR must be chosen.
  {
    rosbag::Bag bag(file, rosbag::bagmode::Append);
    for (int i = 0; i < 10; ++i) bag.write("/velodyne_points", at(0.1 * i + 0.01), cloud(0.1 * i, "rear_lidar"));
  }
  EXPECT_THAT(error_of(options(file)), HasSubstr("several LiDARs share /velodyne_points: rear_lidar, velodyne; choose one with --lidar-frame"));
  BagOptions chosen = options(file);
  chosen.lidar_frame = "velodyne";
  BagSource source(chosen);
  EXPECT_EQ(all(source).size(), 10U);
  EXPECT_EQ(source.dropped().at(MessageFault::frame), 10);
}

}  // namespace
}  // namespace sgraph
