#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <optional>

#include "sgraph_slam/core/mapping/back_end.hpp"
#include "sgraph_slam/core/util/worker.hpp"
#include "sgraph_slam/ros/keyframe_matcher.hpp"

namespace sgraph {

/// What readers get: a snapshot of the graph, and where the LiDAR is on the robot that made it.
struct LiveMap {
  GraphSnapshotPtr graph;  ///< never null
  Pose T_base_lidar;
  DecisionLog decided{};    ///< since the state before
  std::int64_t number = 0;  ///< counts the states, also over maps that were begun anew
};

/// Owns the back end on a thread of its own: no other thread touches the graph. Keyframes are never dropped: each is a part of the map. The clouds of
/// those that it has taken are in a temporary file. All functions may be called from any thread.
class BackEndThread {
 public:
  /// `changed` is called on the thread with each new state.
  BackEndThread(const MappingParams& params, const std::string& map_frame, std::function<void(const LiveMap&, double milliseconds)> changed,
                std::function<void(const std::string&)> failed);

  /// Takes a keyframe. One that doesn't come after the last (a recording that began again) starts a new map.
  void process(MatchedKeyframe keyframe);

  /// Optimises after all that waits. Nothing when it takes longer than `limit`; it is then done later all the same.
  std::optional<LiveMap> optimize(std::chrono::milliseconds limit);

  /// Forgets the map; the next keyframe begins another. False when it takes longer than `limit`.
  bool reset(std::chrono::milliseconds limit);

  /// The newest state.
  [[nodiscard]] LiveMap state() const;

  [[nodiscard]] std::size_t waiting() const { return worker_.waiting(); }

 private:
  using Task = std::function<void()>;

  void take(const MatchedKeyframe& keyframe);
  void start_over();
  void put(GraphSnapshotPtr graph, double milliseconds);

  const MappingParams params_;
  const std::string map_frame_;
  const std::function<void(const LiveMap&, double)> changed_;
  const std::function<void(const std::string&)> failed_;

  std::optional<BackEnd> back_end_;  // this and the next are used by the thread alone
  KeyframeId last_;
  std::size_t told_ = 0;           // decisions
  std::size_t told_failures_ = 0;  // of steps
  Pose T_base_lidar_;
  mutable std::mutex mutex_;
  LiveMap state_;  // guarded by mutex_
  Worker<Task> worker_;
};

}  // namespace sgraph
