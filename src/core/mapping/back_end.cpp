#include "sgraph_slam/core/mapping/back_end.hpp"

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/graph/solver.hpp"
#include "sgraph_slam/core/mapping/add_keyframe.hpp"
#include "sgraph_slam/core/mapping/make_snapshot.hpp"
#include "sgraph_slam/core/mapping/map_state.hpp"
#include "sgraph_slam/core/places/place_factors.hpp"
#include "sgraph_slam/core/places/topology.hpp"
#include "sgraph_slam/core/planes/add_observations.hpp"
#include "sgraph_slam/core/planes/drop_planes.hpp"
#include "sgraph_slam/core/planes/merge_duplicates.hpp"
#include "sgraph_slam/core/planes/passages.hpp"

namespace sgraph {
namespace {

constexpr int returns_apart = 5;     // keyframes between two global solves because a place was seen again
constexpr std::size_t retries = 12;  // positions without a place that are looked at again after a global solve

DominantFrameParams frame_params() { return {}; }

Eigen::Vector2d ground(const Pose& pose) { return pose.translation.head<2>(); }

}  // namespace

class BackEnd::Implementation {
 public:
  Implementation(const MappingParams& params, const Pose& T_base_lidar)
      : state_(params, T_base_lidar), snapshot_(std::make_shared<GraphSnapshot>()) {}

  GraphSnapshotPtr process(const Keyframe& keyframe, const PlaneSegments& segments) {
    if (!add_keyframe(state_, keyframe)) return snapshot_;
    optimized_ = false;
    const AssociationResult seen = add_observations(committer_, state_.planes, keyframe, segments);
    ++since_global_;
    summary_ = {};
    if (state_.params.solving.window > 0) solve_window();
    update_frame();
    if (state_.params.topological_layer) {
      const std::vector<Wall> walls = counted_walls();
      state_.layer.judge(state_.graph, walls, &seen.seen, keyframe.id, state_.log);
      visit(walls, keyframe.id);
      synchronise(committer_, state_.layer, state_.planes.map, state_.params.topology);
      add_widths(committer_, state_.layer, segments, seen.planes, state_.params.topology);
    }
    const bool looped = close_loop(committer_, state_.loops, state_.keyframes, state_.planes.drift, state_.planes.marginals);
    if (looped || wants_global(seen)) solve_global(state_.params.solving.iterations);
    place_odometry();
    snapshot_ = make_snapshot(state_, snapshot_->version + 1, summary_, false);
    return snapshot_;
  }

  GraphSnapshotPtr optimize() {
    // Asked twice (at the end of a recording, and again to save it) the map stays as it is.
    if (state_.keyframes.empty() || optimized_) return snapshot_;
    optimized_ = true;
    summary_ = {};
    solve_global(state_.params.solving.final_iterations, true);
    if (state_.params.topological_layer) {
      visit_all();
      solve_global(state_.params.solving.final_iterations);
    }
    find_covariances();
    place_odometry();
    snapshot_ = make_snapshot(state_, snapshot_->version + 1, summary_, true);
    return snapshot_;
  }

  [[nodiscard]] GraphSnapshotPtr snapshot() const { return snapshot_; }
  [[nodiscard]] const DecisionLog& decisions() const { return state_.log; }

 private:
  [[nodiscard]] bool wants_global(const AssociationResult& seen) const {
    const SolveParams& params = state_.params.solving;
    const int due = std::max(params.every, static_cast<int>(params.growth * static_cast<double>(state_.keyframes.size())));
    if (since_global_ >= due) return true;
    return since_global_ >= returns_apart && (seen.returned || !pending_.empty());
  }

  void note(const SolveSummary& summary) {
    const double before = summary_.milliseconds;
    summary_ = summary;
    summary_.milliseconds += before;
  }

  void solve_window() {
    SolverOptions options;
    options.max_iterations = state_.params.solving.window_iterations;
    note(state_.recent.solve(state_.graph, state_.params.solving.window, options));
  }

  void solve_global(int iterations, bool all_pairs = false) {
    drop_passing_planes(committer_, state_.planes, all_pairs);
    SolverOptions options;
    options.max_iterations = iterations;
    note(solve(state_.graph, options));
    since_global_ = 0;
    state_.planes.marginals.forget();
    state_.planes.map.refresh(state_.graph, state_.planes.frame);
    update_frame();
    std::set<PlanePair> shown;
    shown.swap(pending_);
    merge_duplicates(committer_, state_.planes, shown, all_pairs, state_.params.solving.iterations);
    if (!state_.params.topological_layer) return;
    const std::vector<Wall> walls = counted_walls();
    state_.layer.judge(state_.graph, walls, nullptr, committer_.newest(), state_.log);
    revisit(walls);
    synchronise(committer_, state_.layer, state_.planes.map, state_.params.topology);
    add_wall_faces(committer_, state_.planes.map, state_.params.merging.max_angle, state_.params.topology);
    find_openings();
  }

  [[nodiscard]] std::vector<Wall> counted_walls() const {
    std::vector<Wall> walls = state_.planes.map.walls(static_cast<std::size_t>(state_.params.topology.min_views), state_.params.topology.min_height);
    const std::vector<Eigen::Vector2d> path = path_of(state_.graph);
    for (Wall& wall : walls) open_passages(wall, path);
    walls.erase(std::remove_if(walls.begin(), walls.end(), [](const Wall& wall) { return wall.support.empty(); }), walls.end());
    return walls;
  }

  void update_frame() {
    if (!state_.params.semantics.dominant_frame) {
      state_.planes.frame = {0, 1};
      return;
    }
    state_.planes.frame = estimate_dominant_frame(wall_directions(state_.planes.map), state_.planes.frame, frame_params());
  }

  void visit(const std::vector<Wall>& walls, KeyframeId at) {
    const Visit here{committer_.newest(), ground(*state_.graph.find(at)), state_.planes.frame.yaw};
    for (const PlanePair& pair : state_.layer.visit(state_.graph, walls, here, state_.log)) {
      if (state_.params.merging.by_places && state_.planes.refused_merges.count(pair) == 0) pending_.insert(pair);
    }
  }

  // Positions that had no place when the robot was there: the walls that were missing may have been seen since.
  void revisit(const std::vector<Wall>& walls) {
    std::size_t tried = 0;
    for (std::size_t i = 0; i < state_.keyframes.size() && tried < retries; ++i) {
      const auto next = state_.keyframes.upper_bound(last_revisited_);
      const KeyframeId id = next == state_.keyframes.end() ? state_.keyframes.begin()->first : next->first;
      last_revisited_ = id;
      if (state_.layer.covers(ground(*state_.graph.find(id)))) continue;
      visit(walls, id);
      ++tried;
    }
  }

  void visit_all() {
    const std::vector<Wall> walls = counted_walls();
    for (const auto& [id, keyframe] : state_.keyframes) {
      if (!state_.layer.covers(ground(*state_.graph.find(id)))) visit(walls, id);
    }
    synchronise(committer_, state_.layer, state_.planes.map, state_.params.topology);
  }

  void find_openings() {
    std::vector<Eigen::Vector3d> path;
    for (const auto& [id, keyframe] : state_.keyframes) {
      const Pose T_map_odom = *state_.graph.find(id) * keyframe.T_odom_base.inverse();
      for (const StampedPose& scan : keyframe.scans) path.push_back((T_map_odom * scan.pose).translation);
      if (keyframe.scans.empty()) path.push_back(state_.graph.find(id)->translation);
    }
    state_.openings = sgraph::find_openings(state_.layer.places(), path);
  }

  void find_covariances() {
    const Marginals* marginals = state_.planes.marginals.get(state_.graph, 0);
    if (!marginals) return;
    state_.plane_covariances.clear();
    for (const auto& [id, plane] : state_.graph.planes()) {
      if (const auto covariance = marginals->covariance(id)) state_.plane_covariances[id] = *covariance;
    }
  }

  void place_odometry() {
    const Keyframe& newest = state_.keyframes.rbegin()->second;
    state_.T_map_odom = *state_.graph.find(newest.id) * newest.T_odom_base.inverse();
  }

  MapState state_;
  Committer committer_{state_.graph, state_.log};
  GraphSnapshotPtr snapshot_;
  SolveSummary summary_;
  std::set<PlanePair> pending_;  // planes that a place showed to be one
  int since_global_ = 0;
  bool optimized_ = false;  // since the last keyframe
  KeyframeId last_revisited_;
};

BackEnd::BackEnd(const MappingParams& params, const Pose& T_base_lidar) : implementation_(std::make_unique<Implementation>(params, T_base_lidar)) {}
BackEnd::~BackEnd() = default;

GraphSnapshotPtr BackEnd::process(const Keyframe& keyframe, const PlaneSegments& segments) { return implementation_->process(keyframe, segments); }
GraphSnapshotPtr BackEnd::optimize() { return implementation_->optimize(); }
GraphSnapshotPtr BackEnd::snapshot() const { return implementation_->snapshot(); }
const DecisionLog& BackEnd::decisions() const { return implementation_->decisions(); }

}  // namespace sgraph
