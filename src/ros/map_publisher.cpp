#include "sgraph_slam/ros/map_publisher.hpp"

#include <nav_msgs/OccupancyGrid.h>

#include "sgraph_slam/core/io/map_cloud.hpp"
#include "sgraph_slam/core/io/occupancy_grid.hpp"
#include "sgraph_slam/core/io/storey_view.hpp"
#include "sgraph_slam/core/pipeline/pipeline.hpp"
#include "sgraph_slam/ros/cloud_message.hpp"
#include "sgraph_slam/ros/markers.hpp"
#include "sgraph_slam/ros/messages.hpp"
#include "sgraph_slam/ros/shared_pointer.hpp"

namespace sgraph {

namespace {

/// When the map cloud and the floor plan are worth making again: after so many keyframes, or when one has moved so far [m].
constexpr std::size_t new_keyframes = 5;
constexpr double moved = 0.05;
/// Messages of changed markers until all are sent again: heals what a listener missed.
constexpr int parts_before_whole = 30;

nav_msgs::OccupancyGrid to_message(const OccupancyGrid& grid, const std_msgs::Header& header) {
  nav_msgs::OccupancyGrid message;
  message.header = header;
  message.info.map_load_time = header.stamp;
  message.info.resolution = static_cast<float>(grid.resolution);
  message.info.width = static_cast<std::uint32_t>(grid.width);
  message.info.height = static_cast<std::uint32_t>(grid.height);
  message.info.origin.position.x = grid.origin.x();
  message.info.origin.position.y = grid.origin.y();
  message.info.origin.orientation.w = 1;
  message.data = grid.cells;
  return message;
}

std_msgs::Header header_of(const GraphSnapshot& graph) {
  std_msgs::Header header;
  header.frame_id = graph.frame;
  if (!graph.keyframes.empty()) header.stamp = to_ros_time(graph.keyframes.rbegin()->second.stamp);
  return header;
}

}  // namespace

template <class Message>
void MapPublisher::advertise(ros::NodeHandle& node, const char* name, bool latched, Topic& topic) {
  const auto connected = [this, &topic](const ros::SingleSubscriberPublisher&) {
    topic.new_listener = true;
    std::optional<LiveMap> newest;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      newest = newest_;
    }
    if (newest) worker_.push({*newest, false});
  };
  topic.publisher = node.advertise<Message>(name, 10, connected, {}, {}, latched);
}

MapPublisher::MapPublisher(ros::NodeHandle node, const Settings& settings, std::function<void(const std::string&)> failed)
    : settings_(settings),
      live_cloud_(settings.ros.map_leaf),
      live_grid_(settings.params.output),
      worker_(
          1,
          [this](Order& order, bool) {
            publish(order.state, order.whole);
            return Work::done;
          },
          std::move(failed), [](const Order& order) { return !order.whole; }) {
  advertise<sgraph_slam::SceneGraph>(node, "graph", true, graph_);
  advertise<visualization_msgs::MarkerArray>(node, "markers", false, markers_);  // what is latched would be a part
  advertise<nav_msgs::Path>(node, "path", true, path_);
  advertise<Cloud>(node, "map_points", true, map_points_);
  advertise<nav_msgs::OccupancyGrid>(node, "floor_plan", true, floor_plan_);
}

MapPublisher::~MapPublisher() {
  for (Topic* topic : {&graph_, &markers_, &path_, &map_points_, &floor_plan_}) topic->publisher.shutdown();  // nobody connects any more
}

void MapPublisher::show(const LiveMap& state) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    newest_ = state;
    newest_->decided.clear();
  }
  worker_.push({state, false});
}

bool MapPublisher::show_all(const LiveMap& state, std::chrono::milliseconds limit) {
  worker_.push({state, true});
  return worker_.drain(limit);
}

void MapPublisher::publish(const LiveMap& state, bool all) {
  const GraphSnapshot& graph = *state.graph;
  // Sends to those who listen what they haven't got. `worth`: whether what has changed since is worth it; `make(whole)`.
  const auto send = [&](Topic& topic, const auto& worth, const auto& make) {
    const bool asked = topic.new_listener.exchange(false);
    if (topic.publisher.getNumSubscribers() == 0 || (topic.sent == state.number && !asked && !all)) return;
    if (!asked && !all && !worth()) return;
    make(asked || all || topic.sent < 0);
    topic.sent = state.number;
    topic.keyframes.clear();
    for (const auto& [id, keyframe] : graph.keyframes) topic.keyframes[id] = keyframe.T_map_base;
  };
  const auto always = [] { return true; };
  send(graph_, always, [&](bool) { graph_.publisher.publish(to_message(graph)); });
  send(markers_, always, [&](bool whole) {
    whole = whole || ++partial_ >= parts_before_whole;
    if (whole) partial_ = 0;
    const RosSettings& ros = settings_.ros;
    const GraphSnapshot one = ros.storey >= 0 ? of_storey(graph, ros.storey) : GraphSnapshot{};
    const GraphSnapshot& shown = ros.storey >= 0 ? one : graph;
    const visualization_msgs::MarkerArray drawing =
        ros.storey_gap > 0 ? graph_markers(exploded(shown, ros.storey_gap), ros.layer_height) : graph_markers(shown, ros.layer_height);
    const visualization_msgs::MarkerArray changed = changes_.since_last(drawing, whole);
    if (!changed.markers.empty()) markers_.publisher.publish(changed);
  });
  send(path_, always, [&](bool) { path_.publisher.publish(path_of(graph)); });
  send(
      map_points_, [&] { return much_has_changed(graph, map_points_); },
      [&](bool) {
        live_cloud_.update(graph, state.T_base_lidar);
        auto cloud = std::make_shared<Cloud>(live_cloud_.cloud());
        cloud->frame = graph.frame;
        if (!graph.keyframes.empty()) cloud->stamp = graph.keyframes.rbegin()->second.stamp;
        map_points_.publisher.publish(to_boost(CloudPtr(cloud)));
      });
  send(
      floor_plan_, [&] { return much_has_changed(graph, floor_plan_); },
      [&](bool) {
        live_grid_.update(graph, state.T_base_lidar);
        floor_plan_.publisher.publish(to_message(live_grid_.grid(), header_of(graph)));
      });
}

bool MapPublisher::much_has_changed(const GraphSnapshot& graph, const Topic& topic) {
  const std::map<KeyframeId, Pose>& shown = topic.keyframes;
  if (graph.keyframes.size() < shown.size() || graph.keyframes.size() >= shown.size() + new_keyframes || shown.empty()) return true;
  for (const auto& [id, keyframe] : graph.keyframes) {
    const auto before = shown.find(id);
    if (before != shown.end() && (before->second.translation - keyframe.T_map_base.translation).norm() > moved) return true;
  }
  return false;
}

nav_msgs::Path MapPublisher::path_of(const GraphSnapshot& graph) const {
  nav_msgs::Path message;
  message.header = header_of(graph);
  for (const StampedPose& scan : corrected_trajectory(graph)) {
    geometry_msgs::PoseStamped pose;
    pose.header.stamp = to_ros_time(scan.stamp);
    pose.header.frame_id = graph.frame;
    pose.pose = to_message(scan.pose);
    message.poses.push_back(std::move(pose));
  }
  return message;
}

}  // namespace sgraph
