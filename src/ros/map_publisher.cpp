#include "sgraph_slam/ros/map_publisher.hpp"

#include <nav_msgs/OccupancyGrid.h>
#include <nav_msgs/Path.h>

#include "sgraph_slam/core/io/map_cloud.hpp"
#include "sgraph_slam/core/io/occupancy_grid.hpp"
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

MapPublisher::MapPublisher(ros::NodeHandle node, const Settings& settings, std::function<void(const std::string&)> failed)
    : settings_(settings),
      graph_(node.advertise<sgraph_slam::SceneGraph>("graph", 1, true)),
      markers_(node.advertise<visualization_msgs::MarkerArray>("markers", 1, true)),
      path_(node.advertise<nav_msgs::Path>("path", 1, true)),
      map_points_(node.advertise<Cloud>("map_points", 1, true)),
      floor_plan_(node.advertise<nav_msgs::OccupancyGrid>("floor_plan", 1, true)),
      worker_(
          1,
          [this](LiveMap& state, bool hurry) {
            publish(state, hurry);
            return Work::done;
          },
          std::move(failed)) {}

bool MapPublisher::show_all(const LiveMap& state, std::chrono::milliseconds limit) {
  worker_.push(state);
  return worker_.drain(limit);
}

void MapPublisher::publish(const LiveMap& state, bool all) {
  const GraphSnapshot& graph = *state.graph;
  graph_.publish(to_message(graph));
  markers_.publish(graph_markers(graph, settings_.ros.layer_height));
  publish_path(graph);
  if (!all && !much_has_changed(graph)) return;
  shown_.clear();
  for (const auto& [id, keyframe] : graph.keyframes) shown_[id] = keyframe.T_map_base;
  publish_cloud_and_plan(state);
}

bool MapPublisher::much_has_changed(const GraphSnapshot& graph) const {
  if (graph.keyframes.size() < shown_.size() || graph.keyframes.size() >= shown_.size() + new_keyframes || shown_.empty()) return true;
  for (const auto& [id, keyframe] : graph.keyframes) {
    const auto before = shown_.find(id);
    if (before != shown_.end() && (before->second.translation - keyframe.T_map_base.translation).norm() > moved) return true;
  }
  return false;
}

void MapPublisher::publish_path(const GraphSnapshot& graph) {
  nav_msgs::Path message;
  message.header = header_of(graph);
  for (const StampedPose& scan : corrected_trajectory(graph)) {
    geometry_msgs::PoseStamped pose;
    pose.header.stamp = to_ros_time(scan.stamp);
    pose.header.frame_id = graph.frame;
    pose.pose = to_message(scan.pose);
    message.poses.push_back(std::move(pose));
  }
  path_.publish(message);
}

void MapPublisher::publish_cloud_and_plan(const LiveMap& state) {
  const GraphSnapshot& graph = *state.graph;
  auto cloud = std::make_shared<Cloud>(map_cloud(graph, state.T_base_lidar, settings_.ros.map_leaf));
  cloud->frame = graph.frame;
  if (!graph.keyframes.empty()) cloud->stamp = graph.keyframes.rbegin()->second.stamp;
  map_points_.publish(to_boost(CloudPtr(cloud)));
  floor_plan_.publish(to_message(make_occupancy_grid(graph, state.T_base_lidar, settings_.params.output), header_of(graph)));
}

}  // namespace sgraph
