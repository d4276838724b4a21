#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>

#include "optimize.hpp"
#include "problem.hpp"

namespace sgraph {
namespace {

// The pose as the graph takes it.
Pose pose_of(const Block& block) {
  return {Eigen::Map<const Eigen::Quaterniond>(block.data()).normalized(), Eigen::Map<const Eigen::Vector3d>(block.data() + 4)};
}

// Rooms and corridors are estimated along axes that are constants; the solution is for those that it began with.
bool same_axes(const Graph& graph, const VariableId& id, const Room& room) {
  const Room* now = graph.find(std::get<RoomId>(id));
  return now->yaw == room.yaw && now->z == room.z;
}
bool same_axes(const Graph& graph, const VariableId& id, const Corridor& corridor) {
  const Corridor* now = graph.find(std::get<CorridorId>(id));
  return now->yaw == corridor.yaw && now->along == corridor.along && now->z == corridor.z;
}

}  // namespace

class DeferredSolve::Implementation {
 public:
  Implementation(const Graph& graph, const SolverOptions& options)
      : problem_(graph, {}), rooms_(graph.rooms()), corridors_(graph.corridors()), options_(options) {
    if (!graph.keyframes().empty()) newest_ = graph.keyframes().rbegin()->first;
    for (const auto& [id, plane] : graph.planes()) planes_.insert(id);
    result_ = std::async(std::launch::async, [this] {
      const auto start = std::chrono::steady_clock::now();
      Optimized out = optimize(problem_, options_);
      out.summary.milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
      return out;
    });
  }

  SolveSummary finish(Graph& graph) {
    Optimized out = result_.get();  // a copy: the graph may be a copy of one into which it has been written
    const bool finite = std::all_of(out.values.begin(), out.values.end(), [](const Block& block) {
      return std::all_of(block.begin(), block.end(), [](double v) { return std::isfinite(v); });
    });
    if (!finite) {
      out.summary.converged = false;
      out.summary.final_cost = out.summary.initial_cost;
      return out.summary;
    }
    move_along(graph, out.values);
    for (std::size_t i = 0; i < out.values.size(); ++i) {
      const auto& [id, number] = problem_.variables()[i];
      if (number < 0 || !graph.contains(id)) continue;
      if (const auto* room = std::get_if<RoomId>(&id); room != nullptr && !same_axes(graph, id, rooms_.at(*room))) continue;
      if (const auto* corridor = std::get_if<CorridorId>(&id); corridor != nullptr && !same_axes(graph, id, corridors_.at(*corridor))) continue;
      set_from_block(graph, id, out.values[i]);
    }
    return out.summary;
  }

 private:
  // What has come since, by the correction of the newest keyframe that was solved.
  void move_along(Graph& graph, const Problem::Values& values) const {
    const Pose* before = graph.find(newest_);
    const Problem::Variable* variable = problem_.find(newest_);
    if (before == nullptr || variable == nullptr) return;
    const Pose T_new_old = pose_of(values[static_cast<std::size_t>(variable - problem_.variables().data())]) * before->inverse();
    std::vector<std::pair<KeyframeId, Pose>> keyframes;
    for (auto keyframe = graph.keyframes().upper_bound(newest_); keyframe != graph.keyframes().end(); ++keyframe) {
      keyframes.emplace_back(keyframe->first, T_new_old * keyframe->second);
    }
    for (const auto& [id, pose] : keyframes) graph.set(id, pose);
    std::vector<std::pair<PlaneId, Plane>> planes;
    for (const auto& [id, plane] : graph.planes()) {
      if (planes_.count(id) == 0) planes.emplace_back(id, T_new_old * plane);
    }
    for (const auto& [id, plane] : planes) graph.set(id, Plane{plane.normal.normalized(), plane.d});
  }

  Problem problem_;
  std::map<RoomId, Room> rooms_;
  std::map<CorridorId, Corridor> corridors_;
  std::set<PlaneId> planes_;
  KeyframeId newest_;
  SolverOptions options_;
  std::shared_future<Optimized> result_;  // last: it uses the others until it is gone
};

DeferredSolve::DeferredSolve(const Graph& graph, const SolverOptions& options) : implementation_(std::make_unique<Implementation>(graph, options)) {}
DeferredSolve::~DeferredSolve() = default;
DeferredSolve::DeferredSolve(DeferredSolve&&) noexcept = default;
DeferredSolve& DeferredSolve::operator=(DeferredSolve&&) noexcept = default;

SolveSummary DeferredSolve::finish(Graph& graph) { return implementation_->finish(graph); }

}  // namespace sgraph
