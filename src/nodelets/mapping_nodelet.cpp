#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <tf2_ros/transform_broadcaster.h>

#include <pluginlib/class_list_macros.hpp>

#include "sgraph_slam/ros/back_end_thread.hpp"
#include "sgraph_slam/ros/cloud_message.hpp"
#include "sgraph_slam/ros/conversions.hpp"
#include "sgraph_slam/ros/map_directory.hpp"
#include "sgraph_slam/ros/map_publisher.hpp"
#include "sgraph_slam/ros/map_services.hpp"
#include "sgraph_slam/ros/messages.hpp"
#include "sgraph_slam/ros/shared_pointer.hpp"
#include "sgraph_slam/ros/tf_clock.hpp"
#include "stage_nodelet.hpp"

namespace sgraph {

/// `keyframes`, `keyframe_points`, `planes`, `odom` -> tf map -> odom, `graph`, `markers`, `map_points`, `path`, `floor_plan`, services.
class MappingNodelet : public StageNodelet {
 private:
  /// Complete keyframes behind an incomplete one before its missing part is taken for lost.
  static constexpr std::size_t patience = 5;
  /// Keyframes that may wait before it is said that mapping doesn't keep up.
  static constexpr std::size_t many_waiting = 10;

  void start() override {
    ros::NodeHandle& node = getNodeHandle();
    const RosSettings& options = settings().ros;
    const auto failed = [this](const std::string& text) { health().error(text); };
    tf_clock_.emplace(ros::Duration(options.tf_lookahead));
    publisher_ = std::make_unique<MapPublisher>(node, settings(), failed);
    back_end_ = std::make_unique<BackEndThread>(
        settings().params.mapping, options.map_frame, new_map_file(options), start_of(options),
        [this](const LiveMap& state, double milliseconds) { changed(state, milliseconds); }, failed);
    services_ = std::make_unique<MapServices>(getMTNodeHandle(), settings(), *back_end_, *publisher_, [this] { return live(); });
    timer_ = node.createTimer(ros::Duration(1 / options.tf_rate), [this](const ros::TimerEvent&) { send_transform(); });

    const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
    pose_subscriber_ = node.subscribe<geometry_msgs::PoseWithCovarianceStamped>("initialpose", 1, &MappingNodelet::take_pose, this);
    odom_subscriber_ = node.subscribe<nav_msgs::Odometry>("odom", 100, &MappingNodelet::take_odom, this, hints);
    planes_subscriber_ = node.subscribe<sgraph_slam::PlaneSegments>("planes", 1000, &MappingNodelet::take_planes, this, hints);
    cloud_subscriber_ = node.subscribe<Cloud>("keyframe_points", 1000, &MappingNodelet::take_cloud, this, hints);
    keyframe_subscriber_ = node.subscribe<sgraph_slam::Keyframe>("keyframes", 1000, &MappingNodelet::take_keyframe, this, hints);
  }

  // Somebody shows where the robot is in the map.
  void take_pose(const geometry_msgs::PoseWithCovarianceStampedConstPtr& message) {
    const std::optional<Pose> T_map_base = from_message(message->pose.pose);
    if (!T_map_base) return health().error("initial pose refused: its numbers make no sense");
    if (message->header.frame_id != settings().ros.map_frame)
      return health().error("initial pose refused: it is in the frame '" + message->header.frame_id + "', not '" + settings().ros.map_frame + "'");
    back_end_->search_near(*T_map_base);
  }

  void take_keyframe(const sgraph_slam::KeyframeConstPtr& message) {
    std::optional<ReceivedKeyframe> keyframe = from_message(*message);
    if (!keyframe) return health().error("keyframe refused: its numbers make no sense");
    match([&] { matcher_.add(std::move(*keyframe)); });
  }

  void take_cloud(const CloudMessage& cloud) {
    match([&] { matcher_.add(to_std(cloud)); });
  }

  void take_planes(const sgraph_slam::PlaneSegmentsConstPtr& message) {
    std::optional<PlaneSegments> segments = from_message(*message);
    if (!segments) return health().error("planes refused: their numbers make no sense");
    match([&] { matcher_.add(std::move(*segments)); });
  }

  template <class Add>
  void match(Add add) {
    const std::lock_guard<std::mutex> lock(matcher_mutex_);
    const std::size_t before = matcher_.incomplete();
    add();
    for (MatchedKeyframe& keyframe : matcher_.take()) back_end_->process(std::move(keyframe));
    if (matcher_.incomplete() > before) health().error("keyframes lost: a cloud or planes didn't come");
    const std::size_t waiting = back_end_->waiting();
    health().show("waiting", static_cast<double>(waiting));
    if (waiting > many_waiting)
      health().warn("mapping doesn't keep up: " + std::to_string(waiting / many_waiting * many_waiting) + " keyframes wait");
  }

  void take_odom(const nav_msgs::OdometryConstPtr& message) {
    const std::optional<Pose> T_odom_base = from_message(message->pose.pose);
    if (!T_odom_base) return health().error("odometry refused: its numbers make no sense");
    const StampedPose pose{to_stamp(message->header.stamp), back_end_->state().graph->T_map_odom * *T_odom_base};
    const std::lock_guard<std::mutex> lock(live_mutex_);
    tf_clock_->heard(message->header.stamp, ros::Time::now());
    if (!live_.empty() && pose.stamp <= live_.back().stamp) live_.clear();  // the recording began again
    live_.push_back(pose);
  }

  Trajectory live() {
    const std::lock_guard<std::mutex> lock(live_mutex_);
    return live_;
  }

  void send_transform() {
    const LiveMap state = back_end_->state();
    if (!state.placed) return;  // a frame of its own must not pass for the map's
    const std::lock_guard<std::mutex> lock(live_mutex_);
    const std::optional<ros::Time> stamp = tf_clock_->stamp(ros::Time::now());
    if (!stamp) return;
    geometry_msgs::TransformStamped message;
    message.header.stamp = *stamp;
    message.header.frame_id = settings().ros.map_frame;
    message.child_frame_id = settings().ros.odom_frame;
    message.transform = to_transform(state.graph->T_map_odom);
    broadcaster_.sendTransform(message);
  }

  void changed(const LiveMap& state, double milliseconds) {
    publisher_->show(state);
    for (const Decision& d : state.decided) NODELET_INFO("%s %s: %s", d.accepted ? "accepted" : "refused", d.what.c_str(), d.reason.c_str());
    const GraphSnapshot& graph = *state.graph;
    health().worked(milliseconds);
    health().show("keyframes", static_cast<double>(graph.keyframes.size()));
    health().show("planes", static_cast<double>(graph.planes.size()));
    health().show("rooms", static_cast<double>(graph.rooms.size()));
    health().show("corridors", static_cast<double>(graph.corridors.size()));
    if (state.localisation) {
      health().show("place in the map", std::string(to_string(state.localisation->result)) + ": " + state.localisation->reason);
    }
    health().show("last solve [ms]", graph.last_solve.milliseconds);
    health().show("map file", state.store_problem.empty() ? (state.store.empty() ? "none" : state.store) : state.store_problem);
    if (!state.store_problem.empty()) health().error(state.store_problem);  // with each keyframe, as long as it lasts
  }

  std::mutex matcher_mutex_;
  KeyframeMatcher matcher_{patience};  // guarded by matcher_mutex_
  std::mutex live_mutex_;
  std::optional<TfClock> tf_clock_;  // these two are guarded by live_mutex_
  Trajectory live_;
  tf2_ros::TransformBroadcaster broadcaster_;

  std::unique_ptr<MapPublisher> publisher_;
  std::unique_ptr<BackEndThread> back_end_;  // uses what is above; what is below feeds it
  std::unique_ptr<MapServices> services_;
  ros::Timer timer_;
  ros::Subscriber pose_subscriber_;
  ros::Subscriber odom_subscriber_;
  ros::Subscriber planes_subscriber_;
  ros::Subscriber cloud_subscriber_;
  ros::Subscriber keyframe_subscriber_;
};

}  // namespace sgraph

PLUGINLIB_EXPORT_CLASS(sgraph::MappingNodelet, nodelet::Nodelet)
