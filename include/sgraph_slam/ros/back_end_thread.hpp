#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

#include "sgraph_slam/core/localisation/mapping_session.hpp"
#include "sgraph_slam/core/store/map_recorder.hpp"
#include "sgraph_slam/core/util/worker.hpp"
#include "sgraph_slam/ros/keyframe_matcher.hpp"

namespace sgraph {

/// What readers get: a snapshot of the graph, and where the LiDAR is on the robot that made it.
struct LiveMap {
  GraphSnapshotPtr graph;  ///< never null
  Pose T_base_lidar;
  DecisionLog decided{};    ///< since the state before
  std::int64_t number = 0;  ///< counts the states, also over maps that were begun anew
  bool placed = true;       ///< false while the place in the map that is taken up is not known: poses are in a frame of their own
  std::optional<Localisation> localisation{};
  std::string store{};          ///< map file that is written; empty: none
  std::string store_problem{};  ///< why it can't be written, as long as that lasts
};

/// Owns the back end on a thread of its own: no other thread touches the graph. Keyframes are never dropped: each is a part of the map. The clouds of
/// those that it has taken are in a temporary file. All functions may be called from any thread.
class BackEndThread {
 public:
  /// `changed` is called on the thread with each new state.
  /// `store`: file of new maps, empty: none is written; one that is there is kept under another name. `start`: the map to take up first.
  BackEndThread(const MappingParams& params, const std::string& map_frame, const std::string& store, SessionStart start,
                std::function<void(const LiveMap&, double milliseconds)> changed, std::function<void(const std::string&)> failed);

  /// Takes a keyframe. One that doesn't come after the last (a recording that began again) starts a new map, or a further session in the map that was
  /// taken up.
  void process(MatchedKeyframe keyframe);

  /// Optimises after all that waits. Nothing when it takes longer than `limit`; it is then done later all the same.
  std::optional<LiveMap> optimize(std::chrono::milliseconds limit);

  /// Forgets the map; the next keyframe begins another. False when it takes longer than `limit`.
  bool reset(std::chrono::milliseconds limit);

  /// Ends this session; the next keyframe begins another, in the map that `start` names. False when it takes longer than `limit`.
  bool begin(SessionStart start, std::chrono::milliseconds limit);

  /// Keyframes that come while paused are left out; the first one after knows how uncertain the way between has made it.
  void pause(bool on);

  /// Searches the place in the map from the next keyframe on, near this pose of the base.
  void search_near(const Pose& T_map_base);

  /// The newest state.
  [[nodiscard]] LiveMap state() const;

  [[nodiscard]] std::size_t waiting() const { return worker_.waiting(); }

 private:
  using Task = std::function<void()>;

  void take(const MatchedKeyframe& keyframe);
  void start_over();
  void take_up_again();
  void open_session();
  [[nodiscard]] Keyframe after_pause(Keyframe keyframe);
  void put(GraphSnapshotPtr graph, double milliseconds);

  const MappingParams params_;
  const std::string map_frame_;
  const std::function<void(const LiveMap&, double)> changed_;
  const std::function<void(const std::string&)> failed_;

  const std::string store_path_;

  SessionStart start_;  // from here on used by the thread alone
  std::unique_ptr<MapStore> store_;
  std::string store_problem_;  // why there is none
  std::unique_ptr<MapRecorder> recorder_;
  std::optional<MappingSession> back_end_;  // uses the recorder
  bool paused_ = false;
  std::optional<Keyframe> away_;  // newest of the keyframes left out; its covariance is that of the way since the last one in the map
  KeyframeId last_;
  std::size_t told_ = 0;           // decisions
  std::size_t told_failures_ = 0;  // of steps
  Pose T_base_lidar_;
  mutable std::mutex mutex_;
  LiveMap state_;  // guarded by mutex_
  Worker<Task> worker_;
};

}  // namespace sgraph
