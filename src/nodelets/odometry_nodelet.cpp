#include <cmath>

#include <sensor_msgs/Imu.h>
#include <std_srvs/Trigger.h>
#include <pluginlib/class_list_macros.hpp>

#include "sgraph_slam/core/util/worker.hpp"
#include "sgraph_slam/ros/cloud_message.hpp"
#include "sgraph_slam/ros/conversions.hpp"
#include "sgraph_slam/ros/fixed_frames.hpp"
#include "sgraph_slam/ros/odometry_publisher.hpp"
#include "sgraph_slam/ros/recording.hpp"
#include "sgraph_slam/ros/shared_pointer.hpp"
#include "stage_nodelet.hpp"

namespace sgraph {

/// `filtered_points`, `robot_odom`, `imu` -> `odom`, tf, `deskewed_points`, `odometry_status`, `keyframes`, `keyframe_points`.
class OdometryNodelet : public StageNodelet {
 private:
  /// A sensor's message, or nothing: the recording has ended.
  using Input = std::optional<SensorEvent>;

  void start() override {
    ros::NodeHandle& node = getNodeHandle();
    frames_ = std::make_unique<FixedFrames>(node, settings().ros);
    publisher_ = std::make_unique<OdometryPublisher>(node, settings());
    worker_ = std::make_unique<Worker<Input>>(
        static_cast<std::size_t>(settings().ros.scan_queue), [this](Input& input, bool hurry) { return work(input, hurry); },
        [this](const std::string& text) { health().error(text); },
        [](const Input& input) { return input && std::holds_alternative<CloudPtr>(*input); });
    finish_ = getMTPrivateNodeHandle().advertiseService("finish", &OdometryNodelet::finish, this);
    const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
    odom_subscriber_ = node.subscribe<nav_msgs::Odometry>("robot_odom", 1000, &OdometryNodelet::take_odometry, this, hints);
    if (settings().ros.use_imu) imu_subscriber_ = node.subscribe<sensor_msgs::Imu>("imu", 1000, &OdometryNodelet::take_imu, this, hints);
    cloud_subscriber_ = node.subscribe<Cloud>("filtered_points", 10, &OdometryNodelet::take_cloud, this, hints);
  }

  void take_cloud(const CloudMessage& cloud) {
    const std::size_t before = worker_->dropped();
    worker_->push(SensorEvent(to_std(cloud)));
    if (worker_->dropped() > before) health().warn("scans dropped: the queue is full");
  }

  void take_odometry(const nav_msgs::OdometryConstPtr& message) {
    const Converted<OdometrySample> sample = to_odometry_sample(*message);
    if (!sample) return health().error("robot odometry refused: " + sample.text);
    const std::string child = message->child_frame_id.empty() ? settings().ros.base_frame : frame_name(message->child_frame_id);
    const std::optional<Pose> T_child_base = frames_->lookup(child, settings().ros.base_frame);
    if (!T_child_base) return health().error(FixedFrames::missing(child, settings().ros.base_frame));
    worker_->push(SensorEvent(moved_along_body(sample.value, *T_child_base)));
  }

  void take_imu(const sensor_msgs::ImuConstPtr& message) {
    const std::string frame = frame_name(message->header.frame_id);
    const std::optional<Pose> T_base_imu = frames_->lookup(settings().ros.base_frame, frame);
    if (!T_base_imu) return health().error(FixedFrames::missing(settings().ros.base_frame, frame));
    const Converted<ImuSample> sample = to_imu_sample(*message, T_base_imu->rotation);
    if (!sample) return health().error("inertial reading refused: " + sample.text);
    worker_->push(SensorEvent(sample.value));
  }

  Work work(Input& input, bool hurry) {
    if (!input) {
      end_recording();
      return Work::done;
    }
    if (const auto* scan = std::get_if<CloudPtr>(&*input)) {
      if (!prepare(**scan)) {
        if (hurry) health().count("scans dropped: no transform");
        return hurry ? Work::done : Work::later;
      }
      if ((*scan)->frame != recording_->lidar_frame()) {
        health().count("scans dropped: frame");
        health().error("cloud refused: its frame is '" + (*scan)->frame + "', but the recording began with '" + recording_->lidar_frame() + "'");
        return Work::done;
      }
    }
    if (recording_) recording_->add(std::move(*input));  // readings before the first scan are of no use
    return Work::done;
  }

  /// Makes sure that there is a recording to which the scan belongs; false while the LiDAR's place on the robot isn't known.
  bool prepare(const Cloud& scan) {
    constexpr double back = 1;  // [s]; smaller steps are the odometry's to refuse
    if (recording_ && recording_->goes_back(scan) > back) {
      health().count("restarts");
      health().error("time went back by " + std::to_string(recording_->goes_back(scan)) + " s: a new recording begins");
      recording_.reset();
    }
    if (recording_) return true;
    const std::optional<Pose> mount = frames_->mount(scan.frame);
    if (!mount) {
      health().error(FixedFrames::missing(settings().ros.base_frame, scan.frame));
      return false;
    }
    recording_.emplace(settings().params.odometry, settings().ros.use_imu, scan.frame, *mount,
                       [this](const CloudPtr& taken, const OdometryOutput& output, double milliseconds) { tell(*taken, output, milliseconds); });
    return true;
  }

  void tell(const Cloud& scan, const OdometryOutput& output, double milliseconds) {
    publisher_->publish(scan.stamp, output, recording_->T_base_lidar());
    if (output.verdict != ScanVerdict::accepted) {
      health().count(std::string("scans dropped: ") + to_string(output.verdict));
      health().warn(std::string("scan refused: ") + to_string(output.verdict));
      return;
    }
    health().worked(milliseconds);
    if (output.live.status == OdometryStatus::predicted) {
      health().warn("scan not matched: moving on by prediction");
    } else if (!output.live.degenerate.empty()) {
      health().warn("the surroundings don't hold every direction of motion");
    }
    health().show("inlier share", output.live.inlier_share);
    if (output.calibration && !output.calibration->beams.empty()) health().show("calibration", output.calibration->text());
    const double latency = (ros::Time::now() - to_ros_time(scan.stamp)).toSec();
    if (std::abs(latency) < 60) health().show("latency [ms]", 1e3 * latency);  // otherwise the clocks have nothing in common
  }

  void end_recording() {
    if (!recording_) return;
    publisher_->publish_keyframes(recording_->finish(), recording_->T_base_lidar());
    recording_.reset();
  }

  bool finish(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    worker_->push(std::nullopt);
    response.success = worker_->drain(service_limit);
    response.message = response.success ? "the last keyframe is closed; another scan begins a new recording" : "still busy";
    return true;
  }

  std::unique_ptr<FixedFrames> frames_;
  std::unique_ptr<OdometryPublisher> publisher_;
  std::optional<Recording> recording_;     // used by the worker alone
  std::unique_ptr<Worker<Input>> worker_;  // uses what is above; what is below feeds it
  ros::ServiceServer finish_;
  ros::Subscriber odom_subscriber_;
  ros::Subscriber imu_subscriber_;
  ros::Subscriber cloud_subscriber_;
};

}  // namespace sgraph

PLUGINLIB_EXPORT_CLASS(sgraph::OdometryNodelet, nodelet::Nodelet)
