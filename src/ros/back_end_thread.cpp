#include "sgraph_slam/ros/back_end_thread.hpp"

#include <algorithm>
#include <filesystem>
#include <future>

#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/io/temporary_clouds.hpp"
#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/util/stopwatch.hpp"

namespace sgraph {

namespace {

GraphSnapshotPtr empty_graph(const std::string& frame) {
  auto graph = std::make_shared<GraphSnapshot>();
  graph->frame = frame;
  return graph;
}

/// The core calls the map's frame "map"; here it may have another name.
GraphSnapshotPtr in_frame(const GraphSnapshotPtr& graph, const std::string& frame) {
  if (graph->frame == frame) return graph;
  auto renamed = std::make_shared<GraphSnapshot>(*graph);
  renamed->frame = frame;
  return renamed;
}

}  // namespace

BackEndThread::BackEndThread(const MappingParams& params, const std::string& map_frame, const std::string& store, SessionStart start,
                             std::function<void(const LiveMap&, double)> changed, std::function<void(const std::string&)> failed)
    : params_(params),
      map_frame_(map_frame),
      changed_(std::move(changed)),
      failed_(failed),
      store_path_(store),
      start_(std::move(start)),
      state_{empty_graph(map_frame), {}},
      worker_(
          0,
          [](Task& task, bool) {
            task();
            return Work::done;
          },
          failed_) {
  const std::lock_guard<std::mutex> lock(mutex_);
  state_.placed = !start_.map;
}

void BackEndThread::process(MatchedKeyframe keyframe) {
  worker_.push([this, keyframe = std::move(keyframe)] { take(keyframe); });
}

std::optional<LiveMap> BackEndThread::optimize(std::chrono::milliseconds limit) {
  // Shared with the task, which may run when nobody waits any more.
  const auto promise = std::make_shared<std::promise<LiveMap>>();
  std::future<LiveMap> result = promise->get_future();
  worker_.push([this, promise] {
    if (back_end_) {
      Stopwatch watch;
      const GraphSnapshotPtr graph = back_end_->optimize();
      put(graph, watch.lap());
    }
    promise->set_value(state());
  });
  if (result.wait_for(limit) != std::future_status::ready) return {};
  return result.get();
}

bool BackEndThread::begin(SessionStart start, std::chrono::milliseconds limit) {
  const auto promise = std::make_shared<std::promise<void>>();
  std::future<void> result = promise->get_future();
  worker_.push([this, promise, start = std::move(start)] {
    start_ = start;
    start_over();
    promise->set_value();
  });
  return result.wait_for(limit) == std::future_status::ready;
}

void BackEndThread::pause(bool on) {
  worker_.push([this, on] { paused_ = on; });
}

void BackEndThread::search_near(const Pose& T_map_base) {
  worker_.push([this, T_map_base] {
    if (back_end_) {
      back_end_->search_again(T_map_base);
    } else {
      start_.near = T_map_base;
    }
  });
}

bool BackEndThread::reset(std::chrono::milliseconds limit) {
  const auto promise = std::make_shared<std::promise<void>>();
  std::future<void> result = promise->get_future();
  worker_.push([this, promise] {
    start_ = {};
    start_over();
    promise->set_value();
  });
  return result.wait_for(limit) == std::future_status::ready;
}

LiveMap BackEndThread::state() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return state_;
}

void BackEndThread::take(const MatchedKeyframe& matched) {
  const Keyframe& keyframe = matched.received.keyframe;
  if (back_end_ && !(last_ < keyframe.id)) {
    start_over();
    take_up_again();
  }
  const bool first = !back_end_;
  last_ = keyframe.id;
  if (paused_) {
    away_ = after_pause(keyframe);
    return;
  }
  if (first) {
    T_base_lidar_ = matched.received.T_base_lidar;
    open_session();
    away_.reset();
  }
  Stopwatch watch;
  const GraphSnapshotPtr graph = back_end_->process(after_pause(keyframe), matched.segments);
  away_.reset();
  put(graph, watch.lap());
}

Keyframe BackEndThread::after_pause(Keyframe keyframe) {
  if (!away_) return keyframe;
  keyframe.measured.reset();  // from one that was left out
  if (away_->ride) {          // several rides: how far they went together isn't said
    keyframe.ride = keyframe.ride ? unknown_rise : *away_->ride;
  }
  const Matrix6 adjoint = se3_adjoint(keyframe.T_odom_base.inverse() * away_->T_odom_base);
  keyframe.covariance += adjoint * away_->covariance * adjoint.transpose();
  return keyframe;
}

// A map that cannot be written is still worth mapping: that is reported, and the session goes on without a file.
void BackEndThread::open_session() {
  back_end_.emplace(params_, T_base_lidar_, std::make_shared<TemporaryClouds>(), start_);
  if (store_path_.empty() || (start_.map && start_.mode == MapMode::localize)) return;
  StoredSession session;
  session.source = "live";
  session.T_base_lidar = T_base_lidar_;
  session.frame = map_frame_;
  try {
    if (start_.map) {
      store_ = std::make_unique<MapStore>(start_.map->path, MapStore::Mode::extend, session, failed_);
      recorder_ = std::make_unique<MapRecorder>(*store_, start_.map->stored);
    } else {
      make_folder(std::filesystem::path(store_path_).parent_path().string());
      set_aside(store_path_);
      store_ = std::make_unique<MapStore>(store_path_, MapStore::Mode::create, session, failed_);
      recorder_ = std::make_unique<MapRecorder>(*store_);
    }
    back_end_->observe(recorder_.get());
  } catch (const std::exception& error) {
    store_.reset();
    store_problem_ = std::string("no map file is written: ") + error.what();
    failed_(store_problem_);
  }
}

void BackEndThread::start_over() {
  back_end_.reset();
  recorder_.reset();
  store_.reset();
  store_problem_.clear();
  away_.reset();
  told_ = 0;
  told_failures_ = 0;
  put(empty_graph(map_frame_), 0);
}

// For a further session in the map that was taken up: it has grown since it was read, and the robot may be anywhere in it.
void BackEndThread::take_up_again() {
  if (!start_.map) return;
  start_.near.reset();
  if (start_.mode == MapMode::localize) return;
  const std::string path = start_.map->path;
  try {
    start_.map = take_map(path);
  } catch (const std::exception& error) {
    start_ = {};
    failed_(std::string("a new map begins, because the one taken up can't be read any more: ") + error.what());
  }
}

void BackEndThread::put(GraphSnapshotPtr graph, double milliseconds) {
  LiveMap state{in_frame(graph, map_frame_), T_base_lidar_};
  state.placed = !start_.map;
  if (back_end_) {
    const DecisionLog& all = back_end_->decisions();
    state.decided.assign(all.begin() + static_cast<std::ptrdiff_t>(std::min(told_, all.size())), all.end());
    told_ = all.size();
    const std::vector<std::string>& failures = back_end_->failures();
    for (; told_failures_ < failures.size(); ++told_failures_) failed_(failures[told_failures_]);
    state.placed = back_end_->is_placed();
    state.localisation = back_end_->localisation();
    state.store = store_ ? store_->path() : "";
    state.store_problem = store_ ? store_->problem() : store_problem_;
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    state.number = state_.number + 1;
    state_ = state;
  }
  changed_(state, milliseconds);
}

}  // namespace sgraph
