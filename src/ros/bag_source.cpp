#include "sgraph_slam/ros/bag_source.hpp"

#include <stdexcept>

#include "bag_files.hpp"
#include "sgraph_slam/core/pipeline/scan_gate.hpp"

namespace sgraph {

class BagSource::Implementation {
 public:
  explicit Implementation(const BagOptions& options)
      : options_(options), files_(options.bags), gate_(!options.odom_topic.empty(), !options.imu_topic.empty()) {
    files_.read_static_transforms(transforms_);
    std::vector<std::string> topics{options_.points_topic};
    files_.require(options_.points_topic, "sensor_msgs/PointCloud2");
    if (!options_.odom_topic.empty()) {
      files_.require(options_.odom_topic, "nav_msgs/Odometry");
      topics.push_back(options_.odom_topic);
    }
    if (!options_.imu_topic.empty()) {
      files_.require(options_.imu_topic, "sensor_msgs/Imu");
      topics.push_back(options_.imu_topic);
    }
    const ros::Time from = options_.start > 0 ? files_.begin() + ros::Duration(options_.start) : ros::TIME_MIN;
    const ros::Time to = options_.duration ? files_.begin() + ros::Duration(options_.start + *options_.duration) : ros::TIME_MAX;
    scans_ = files_.view({options_.points_topic}, from, to);
    look_at_first_scan();
    messages_ = files_.view(topics, from, to);
    BagFiles::guarded(files_.names(), [&] { at_ = messages_->begin(); });
  }

  std::optional<SensorEvent> next() {
    while (true) {
      if (auto event = gate_.pop()) return event;
      if (closed_) return std::nullopt;
      BagFiles::guarded(files_.names(), [&] { read_one(); });
    }
  }

  [[nodiscard]] int scan_count() const { return static_cast<int>(scans_->size()); }

  Pose T_base_lidar;
  std::string lidar_frame;
  std::map<MessageFault, int> dropped;

 private:
  // The first scan tells the LiDAR's frame, and whether scans of this recording can be used at all.
  void look_at_first_scan() {
    BagFiles::guarded(files_.names(), [&] {
      if (scans_->size() == 0) throw std::runtime_error(files_.names() + ": no scan on " + options_.points_topic + " within the chosen time");
      const auto cloud = to_cloud(message<sensor_msgs::PointCloud2>(*scans_->begin()));
      if (!cloud) throw std::runtime_error(files_.names() + ": " + options_.points_topic + ": " + cloud.text);
      lidar_frame = cloud.value->frame;
    });
    if (options_.T_base_lidar) transforms_.add(options_.base_frame, lidar_frame, *options_.T_base_lidar);
    if (options_.T_base_lidar) {
      T_base_lidar = *options_.T_base_lidar;
      return;
    }
    try {
      T_base_lidar = transforms_.lookup(options_.base_frame, lidar_frame);
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(files_.names() + ": " + error.what() +
                               "; give it with --base-to-lidar \"X Y Z YAW PITCH ROLL\", or take the LiDAR as the base with --base-frame " +
                               lidar_frame);
    }
  }

  void read_one() {
    if (at_ == messages_->end()) {
      closed_ = true;
      gate_.close();
      return;
    }
    const rosbag::MessageInstance& instance = *at_;
    const std::string& topic = instance.getTopic();
    if (topic == options_.points_topic) {
      take_scan(message<sensor_msgs::PointCloud2>(instance));
    } else if (topic == options_.odom_topic) {
      take_odometry(message<nav_msgs::Odometry>(instance));
    } else {
      take_imu(message<sensor_msgs::Imu>(instance));
    }
    ++at_;
  }

  template <class Message>
  const Message& message(const rosbag::MessageInstance& instance) {
    const auto message = instance.instantiate<Message>();
    if (!message) throw std::runtime_error(files_.names() + ": " + instance.getTopic() + " is not of one type (" + instance.getDataType() + ")");
    holder_ = message;
    return *message;
  }

  void take_scan(const sensor_msgs::PointCloud2& message) {
    const auto cloud = to_cloud(message);
    if (!cloud) {
      ++dropped[cloud.fault];
      return;
    }
    if (cloud.value->frame != lidar_frame) {
      throw std::runtime_error(files_.names() + ": the frame of " + options_.points_topic + " changes from " + lidar_frame + " to " +
                               cloud.value->frame + ": two LiDARs on one topic?");
    }
    gate_.push(cloud.value);
  }

  void take_odometry(const nav_msgs::Odometry& message) {
    const auto sample = to_odometry_sample(message);
    if (!sample) return;
    const std::string child = frame_name(message.child_frame_id);
    gate_.push(moved_along_body(sample.value, child.empty() ? Pose() : lookup(child, options_.base_frame, options_.odom_topic)));
  }

  void take_imu(const sensor_msgs::Imu& message) {
    const std::string frame = frame_name(message.header.frame_id);
    const auto sample = to_imu_sample(message, lookup(options_.base_frame, frame, options_.imu_topic).rotation);
    if (sample) gate_.push(sample.value);
  }

  [[nodiscard]] Pose lookup(const std::string& target, const std::string& source, const std::string& topic) const {
    try {
      return transforms_.lookup(target, source);
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(files_.names() + ": " + topic + ": " + error.what());
    }
  }

  BagOptions options_;
  BagFiles files_;
  StaticTransforms transforms_;
  std::unique_ptr<rosbag::View> scans_;
  std::unique_ptr<rosbag::View> messages_;
  rosbag::View::iterator at_;
  ScanGate gate_;
  boost::shared_ptr<const void> holder_;  // of the message at hand
  bool closed_ = false;
};

BagSource::BagSource(const BagOptions& options) : implementation_(std::make_unique<Implementation>(options)) {}
BagSource::~BagSource() = default;

std::optional<SensorEvent> BagSource::next() { return implementation_->next(); }
Pose BagSource::T_base_lidar() const { return implementation_->T_base_lidar; }
int BagSource::scan_count() const { return implementation_->scan_count(); }
const std::string& BagSource::lidar_frame() const { return implementation_->lidar_frame; }
const std::map<MessageFault, int>& BagSource::dropped() const { return implementation_->dropped; }

}  // namespace sgraph
