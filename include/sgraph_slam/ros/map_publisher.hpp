#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include <nav_msgs/Path.h>
#include <ros/node_handle.h>

#include "sgraph_slam/core/io/map_cloud.hpp"
#include "sgraph_slam/core/io/occupancy_grid.hpp"
#include "sgraph_slam/core/util/worker.hpp"
#include "sgraph_slam/ros/back_end_thread.hpp"
#include "sgraph_slam/ros/markers.hpp"
#include "sgraph_slam/ros/settings.hpp"

namespace sgraph {

/// Shows the map to whoever listens, and makes nothing for nobody: `graph` and `path` with each state, of `markers` what has changed, `map_points`
/// and `floor_plan`, which cost more, when enough has changed. A new listener gets the whole of the newest state. Works on a thread of its own, so
/// that a large map holds back neither the back end nor the callbacks, and takes the newest state only.
class MapPublisher {
 public:
  MapPublisher(ros::NodeHandle node, const Settings& settings, std::function<void(const std::string&)> failed);

  ~MapPublisher();

  /// Takes the newest state; any thread.
  void show(const LiveMap& state);

  /// Shows this state with all that belongs to it, and waits for that; false when it takes longer than `limit`.
  bool show_all(const LiveMap& state, std::chrono::milliseconds limit);

 private:
  /// A state to show; `whole`: to all listeners, with all that belongs to it.
  struct Order {
    LiveMap state;
    bool whole = false;
  };

  /// A topic and what has been sent on it.
  struct Topic {
    ros::Publisher publisher;
    std::atomic<bool> new_listener{false};
    std::int64_t sent = -1;                // number of the state; this and the next are used by the worker alone
    std::map<KeyframeId, Pose> keyframes;  // as they were then
  };

  template <class Message>
  void advertise(ros::NodeHandle& node, const char* name, bool latched, Topic& topic);
  void publish(const LiveMap& state, bool all);
  [[nodiscard]] static bool much_has_changed(const GraphSnapshot& graph, const Topic& topic);
  [[nodiscard]] nav_msgs::Path path_of(const GraphSnapshot& graph) const;

  const Settings settings_;
  Topic graph_, markers_, path_, map_points_, floor_plan_;
  LiveMapCloud live_cloud_;  // these are used by the worker alone
  LiveOccupancyGrid live_grid_;
  MarkerChanges changes_;
  int partial_ = 0;  // marker messages since the last whole one
  std::mutex mutex_;
  std::optional<LiveMap> newest_;  // guarded by mutex_
  Worker<Order> worker_;
};

}  // namespace sgraph
