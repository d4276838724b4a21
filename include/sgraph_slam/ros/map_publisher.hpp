#pragma once

#include <functional>
#include <string>

#include <ros/node_handle.h>

#include "sgraph_slam/core/util/worker.hpp"
#include "sgraph_slam/ros/back_end_thread.hpp"
#include "sgraph_slam/ros/settings.hpp"

namespace sgraph {

/// Shows the map: `graph`, `markers` and `path` with each state, `map_points` and `floor_plan`, which cost more, when enough has changed; all
/// latched. Works on a thread of its own, so that a large map holds back neither the back end nor the callbacks, and takes the newest state only.
class MapPublisher {
 public:
  MapPublisher(ros::NodeHandle node, const Settings& settings, std::function<void(const std::string&)> failed);

  void show(const LiveMap& state) { worker_.push(state); }

  /// Shows this state with all that belongs to it, and waits for that; false when it takes longer than `limit`.
  bool show_all(const LiveMap& state, std::chrono::milliseconds limit);

 private:
  void publish(const LiveMap& state, bool all);
  [[nodiscard]] bool much_has_changed(const GraphSnapshot& graph) const;
  void publish_path(const GraphSnapshot& graph);
  void publish_cloud_and_plan(const LiveMap& state);

  const Settings settings_;
  ros::Publisher graph_;
  ros::Publisher markers_;
  ros::Publisher path_;
  ros::Publisher map_points_;
  ros::Publisher floor_plan_;
  std::map<KeyframeId, Pose> shown_;  // keyframes when the cloud and the plan were last published; used by the worker alone
  Worker<LiveMap> worker_;
};

}  // namespace sgraph
