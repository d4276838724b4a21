#include "sgraph_slam/ros/bag_source.hpp"

#include <algorithm>
#include <stdexcept>

#include "bag_files.hpp"
#include "sgraph_slam/core/pipeline/scan_gate.hpp"
#include "sgraph_slam/core/sensor/sensor_adapter.hpp"
#include "sgraph_slam/core/sensor/stamp_filter.hpp"
#include "sgraph_slam/ros/velodyne_scan.hpp"

namespace sgraph {
namespace {

constexpr const char* cloud_type = "sensor_msgs/PointCloud2";
constexpr const char* packet_type = "velodyne_msgs/VelodyneScan";
constexpr std::size_t shown_clouds = 60;  // looked at ahead of mapping: a turn in slices of six degrees, or six seconds of whole turns
constexpr std::size_t shown_turns = 12;   // of whole turns fewer tell as much

}  // namespace

class BagSource::Implementation {
 public:
  explicit Implementation(const BagOptions& options)
      : options_(options),
        files_(options.bags),
        adapter_(options.sensor),
        stamps_(options.odom_topic.empty() && options.imu_topic.empty() ? StampFilter::Backward::restamps : StampFilter::Backward::passes),
        gate_(!options.odom_topic.empty(), !options.imu_topic.empty()) {
    choose_points_topic();
    std::vector<std::string> topics{points_topic};
    if (!options_.odom_topic.empty()) {
      files_.require(options_.odom_topic, {"nav_msgs/Odometry"});
      topics.push_back(options_.odom_topic);
    }
    if (!options_.imu_topic.empty()) {
      files_.require(options_.imu_topic, {"sensor_msgs/Imu"});
      topics.push_back(options_.imu_topic);
    }
    const ros::Time from = options_.start > 0 ? files_.begin() + ros::Duration(options_.start) : ros::TIME_MIN;
    const ros::Time to = options_.duration ? files_.begin() + ros::Duration(options_.start + *options_.duration) : ros::TIME_MAX;
    scans_ = files_.view({points_topic}, from, to);
    BagFiles::guarded(files_.names(), [&] { look_at_first_scans(); });
    find_mount();
    messages_ = files_.view(topics, from, to);
    BagFiles::guarded(files_.names(), [&] { at_ = messages_->begin(); });
  }

  std::optional<SensorEvent> next() {
    while (true) {
      while (gate_.take_dropped()) ++dropped[MessageFault::stamp];
      if (auto event = gate_.pop()) return event;
      if (closed_) return std::nullopt;
      BagFiles::guarded(files_.names(), [&] { read_one(); });
    }
  }

  [[nodiscard]] int scan_count() const {
    const SensorDescription& sensor = adapter_.description();
    const double share = sensor.slices && sensor.coverage_deg > 0 ? sensor.coverage_deg / 360 : 1;
    return static_cast<int>(share * static_cast<double>(scans_->size()));
  }
  [[nodiscard]] const SensorDescription& sensor() const { return adapter_.description(); }

  Pose T_base_lidar;
  std::string points_topic;
  std::string lidar_frame;
  std::map<MessageFault, int> dropped;
  std::map<std::string, int> readings_dropped;
  std::vector<std::string> notes;

 private:
  void choose_points_topic() {
    points_topic = options_.points_topic;
    if (points_topic.empty()) {
      std::vector<std::string> topics = files_.topics(cloud_type);
      if (topics.empty()) topics = files_.topics(packet_type);
      if (topics.size() > 1) {
        std::string names;
        for (const std::string& topic : topics)
          names += (names.empty() ? "" : ", ") + topic + " (" + std::to_string(files_.count(topic)) + " messages)";
        throw std::runtime_error(files_.names() + ": several topics hold clouds: " + names + "; choose one with --points-topic");
      }
      if (topics.empty()) files_.require("", {cloud_type, packet_type});
      points_topic = topics.front();
    }
    files_.require(points_topic, {cloud_type, packet_type});
  }

  // A message as a raw scan, whichever of the two types it is.
  Converted<RawScan> raw_scan(const rosbag::MessageInstance& instance) {
    Converted<RawScan> raw;
    if (instance.getDataType() == packet_type) {
      raw = to_raw_scan(message<VelodyneScanMessage>(instance), true, instance.getTime());
    } else {
      raw = to_raw_scan(message<sensor_msgs::PointCloud2>(instance), instance.getTime());
    }
    if (!raw) return raw;
    // Without a stamp a scan was taken when it was received, less what nobody knows.
    if (stamps_missing_) raw.value.cloud.stamp = *raw.value.received;
    return raw;
  }

  // The first scans tell the LiDAR's frame and conventions, and whether scans of this recording can be used at all.
  void look_at_first_scans() {
    if (scans_->size() == 0) throw std::runtime_error(files_.names() + ": no scan on " + points_topic + " within the chosen time");
    std::vector<RawScan> shown;
    std::map<std::string, int> frames;
    std::string first_fault;
    std::size_t unstamped = 0, points = 0;
    for (auto instance = scans_->begin(); instance != scans_->end() && shown.size() < shown_clouds; ++instance) {
      auto raw = raw_scan(*instance);
      if (!raw) {
        if (first_fault.empty()) first_fault = raw.text;
        continue;
      }
      ++frames[raw.value.cloud.frame];
      unstamped += raw.value.cloud.stamp.nanoseconds == 0;
      points += raw.value.cloud.size();
      shown.push_back(std::move(raw.value));
      if (shown.size() >= shown_turns && points / shown.size() > 10'000) break;  // whole turns
    }
    if (shown.empty()) throw std::runtime_error(files_.names() + ": " + points_topic + ": " + first_fault);
    choose_frame(frames);
    stamps_missing_ = 2 * unstamped > shown.size();
    if (stamps_missing_) notes.push_back(points_topic + " has no stamps: the times of recording are taken instead");
    std::vector<double> lags;
    for (RawScan& raw : shown) {
      if (stamps_missing_) raw.cloud.stamp = *raw.received;
      lags.push_back(*raw.received - raw.cloud.stamp);
    }
    std::vector<double> sorted = lags;
    // Stamps at the beginning that agree with none of the next two.
    const auto apart = [&lags](std::size_t a, std::size_t b) { return std::abs(lags[a] - lags[b]) > StampFilter::far; };
    while (leading_ + 2 < lags.size() && apart(leading_, leading_ + 1) && apart(leading_, leading_ + 2)) ++leading_;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    const double usual = sorted[sorted.size() / 2];
    for (std::size_t i = 0; i < shown.size(); ++i) {
      if (of_this_lidar(shown[i].cloud.frame) && std::abs(lags[i] - usual) < StampFilter::far) adapter_.look(shown[i]);
    }
    adapter_.settle();
  }

  void choose_frame(const std::map<std::string, int>& frames) {
    std::string most;
    std::string names;
    int sharing = 0, all = 0, count = 0;
    for (const auto& [frame, number] : frames) all += number;
    for (const auto& [frame, number] : frames) {
      if (frame.empty()) continue;
      if (number > count) most = frame, count = number;
      if (4 * number < all) continue;
      ++sharing;
      names += (names.empty() ? "" : ", ") + frame;
    }
    if (!options_.lidar_frame.empty()) {
      renamed_ = frames.count(options_.lidar_frame) == 0;
      lidar_frame = options_.lidar_frame;
      return;
    }
    if (sharing > 1) {
      throw std::runtime_error(files_.names() + ": several LiDARs share " + points_topic + ": " + names + "; choose one with --lidar-frame");
    }
    lidar_frame = most;
    if (most.empty() && !options_.T_base_lidar) {
      throw std::runtime_error(files_.names() + ": the clouds on " + points_topic +
                               " name no frame; give it with --lidar-frame, or the LiDAR's place with --base-to-lidar \"X Y Z YAW PITCH ROLL\"");
    }
  }

  void find_mount() {
    if (options_.T_base_lidar) {
      T_base_lidar = *options_.T_base_lidar;
      files_.read_static_transforms(transforms_);
      if (!lidar_frame.empty()) transforms_.add(options_.base_frame, lidar_frame, T_base_lidar);
      return;
    }
    files_.read_static_transforms(transforms_);
    if (!transforms_.connects(options_.base_frame, lidar_frame)) {
      files_.read_constant_transforms(transforms_);
      if (transforms_.connects(options_.base_frame, lidar_frame)) {
        notes.push_back("the transform from " + lidar_frame + " to " + options_.base_frame +
                        " isn't in /tf_static; what never changes in /tf is taken");
      }
    }
    notes.insert(notes.end(), transforms_.notes().begin(), transforms_.notes().end());
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
      close();
      return;
    }
    const rosbag::MessageInstance& instance = *at_;
    const std::string& topic = instance.getTopic();
    if (topic == points_topic) {
      take_scan(instance);
    } else if (topic == options_.odom_topic) {
      take_odometry(message<nav_msgs::Odometry>(instance));
    } else {
      take_imu(message<sensor_msgs::Imu>(instance));
    }
    ++at_;
  }

  void close() {
    hand_on(adapter_.flush(), std::nullopt);
    stamps_.finish();
    if (stamps_.dropped() > 0) dropped[MessageFault::stamp] += stamps_.dropped();
    if (stamps_.shift() > 0) notes.push_back("the clock was set back in this recording: the scans after it go on where those before it ended");
    closed_ = true;
    gate_.close();
  }

  template <class Message>
  const Message& message(const rosbag::MessageInstance& instance) {
    const auto message = instance.instantiate<Message>();
    if (!message) throw std::runtime_error(files_.names() + ": " + instance.getTopic() + " is not of one type (" + instance.getDataType() + ")");
    holder_ = message;
    return *message;
  }

  [[nodiscard]] bool of_this_lidar(const std::string& frame) const { return renamed_ || frame == lidar_frame; }

  void take_scan(const rosbag::MessageInstance& instance) {
    auto raw = raw_scan(instance);
    if (!raw) {
      ++dropped[raw.fault];
      return;
    }
    if (!of_this_lidar(raw.value.cloud.frame)) {
      ++dropped[MessageFault::frame];
      return;
    }
    raw.value.cloud.frame = lidar_frame;
    if (leading_ > 0) {
      --leading_;
      ++dropped[MessageFault::stamp];
      return;
    }
    const std::optional<Stamp> received = raw.value.received;
    hand_on(adapter_.take(std::move(raw.value)), received);
  }

  void hand_on(const AdaptedScans& adapted, const std::optional<Stamp>& received) {
    if (adapted.fault != RawFault::none) ++dropped[adapted.fault == RawFault::times ? MessageFault::times : MessageFault::beams];
    for (const CloudPtr& scan : adapted.scans) {
      for (const CloudPtr& passing : stamps_.push(scan, received)) gate_.push(passing);
    }
  }

  void take_odometry(const nav_msgs::Odometry& message) {
    const auto sample = to_odometry_sample(message);
    if (!sample) {
      ++readings_dropped[options_.odom_topic + " " + to_string(sample.fault)];
      return;
    }
    const std::string child = frame_name(message.child_frame_id);
    if (const auto T_child_base = child.empty() ? Pose() : lookup(child, options_.base_frame, options_.odom_topic)) {
      gate_.push(moved_along_body(sample.value, *T_child_base));
    }
  }

  void take_imu(const sensor_msgs::Imu& message) {
    const std::string frame = frame_name(message.header.frame_id);
    const auto T_base_imu = lookup(options_.base_frame, frame, options_.imu_topic);
    if (!T_base_imu) return;
    const auto sample = to_imu_sample(message, T_base_imu->rotation);
    if (sample) {
      gate_.push(sample.value);
    } else {
      ++readings_dropped[options_.imu_topic + " " + to_string(sample.fault)];
    }
  }

  // Between frames that are fixed to each other. A sensor whose frame can't be placed ends the run; a reading of another frame among good ones is
  // left out.
  [[nodiscard]] std::optional<Pose> lookup(const std::string& target, const std::string& source, const std::string& topic) {
    try {
      const Pose pose = transforms_.lookup(target, source);
      placed_.insert(topic);
      return pose;
    } catch (const std::runtime_error& error) {
      if (placed_.count(topic) == 0) throw std::runtime_error(files_.names() + ": " + topic + ": " + error.what());
      ++readings_dropped[topic + " frame"];
      return std::nullopt;
    }
  }

  BagOptions options_;
  BagFiles files_;
  StaticTransforms transforms_;
  SensorAdapter adapter_;
  StampFilter stamps_;
  std::unique_ptr<rosbag::View> scans_;
  std::unique_ptr<rosbag::View> messages_;
  rosbag::View::iterator at_;
  ScanGate gate_;
  std::set<std::string> placed_;  // topics whose frame could be placed once
  bool renamed_ = false;          // every scan is taken for one of lidar_frame
  bool stamps_missing_ = false;
  std::size_t leading_ = 0;               // scans at the beginning whose stamps are wrong
  boost::shared_ptr<const void> holder_;  // of the message at hand
  bool closed_ = false;
};

BagSource::BagSource(const BagOptions& options) : implementation_(std::make_unique<Implementation>(options)) {}
BagSource::~BagSource() = default;

std::optional<SensorEvent> BagSource::next() { return implementation_->next(); }
Pose BagSource::T_base_lidar() const { return implementation_->T_base_lidar; }
int BagSource::scan_count() const { return implementation_->scan_count(); }
const std::string& BagSource::points_topic() const { return implementation_->points_topic; }
const std::string& BagSource::lidar_frame() const { return implementation_->lidar_frame; }
const std::map<MessageFault, int>& BagSource::dropped() const { return implementation_->dropped; }
const std::map<std::string, int>& BagSource::readings_dropped() const { return implementation_->readings_dropped; }
const SensorDescription& BagSource::sensor() const { return implementation_->sensor(); }
const std::vector<std::string>& BagSource::notes() const { return implementation_->notes; }

}  // namespace sgraph
