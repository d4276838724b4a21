#include "sgraph_slam/ros/back_end_thread.hpp"

#include <algorithm>
#include <future>

#include "sgraph_slam/core/io/temporary_clouds.hpp"
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

BackEndThread::BackEndThread(const MappingParams& params, const std::string& map_frame, std::function<void(const LiveMap&, double)> changed,
                             std::function<void(const std::string&)> failed)
    : params_(params),
      map_frame_(map_frame),
      changed_(std::move(changed)),
      failed_(std::move(failed)),
      state_{empty_graph(map_frame), {}},
      worker_(
          0,
          [](Task& task, bool) {
            task();
            return Work::done;
          },
          failed_) {}

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

bool BackEndThread::reset(std::chrono::milliseconds limit) {
  const auto promise = std::make_shared<std::promise<void>>();
  std::future<void> result = promise->get_future();
  worker_.push([this, promise] {
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
  if (back_end_ && !(last_ < keyframe.id)) start_over();
  if (!back_end_) {
    T_base_lidar_ = matched.received.T_base_lidar;
    back_end_.emplace(params_, T_base_lidar_, std::make_shared<TemporaryClouds>());
  }
  last_ = keyframe.id;
  Stopwatch watch;
  const GraphSnapshotPtr graph = back_end_->process(keyframe, matched.segments);
  put(graph, watch.lap());
}

void BackEndThread::start_over() {
  back_end_.reset();
  told_ = 0;
  told_failures_ = 0;
  put(empty_graph(map_frame_), 0);
}

void BackEndThread::put(GraphSnapshotPtr graph, double milliseconds) {
  LiveMap state{in_frame(graph, map_frame_), T_base_lidar_};
  if (back_end_) {
    const DecisionLog& all = back_end_->decisions();
    state.decided.assign(all.begin() + static_cast<std::ptrdiff_t>(std::min(told_, all.size())), all.end());
    told_ = all.size();
    const std::vector<std::string>& failures = back_end_->failures();
    for (; told_failures_ < failures.size(); ++told_failures_) failed_(failures[told_failures_]);
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    state.number = state_.number + 1;
    state_ = state;
  }
  changed_(state, milliseconds);
}

}  // namespace sgraph
