#pragma once

#include <set>
#include <vector>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/mapping/kept_map.hpp"
#include "sgraph_slam/core/mapping/map_state.hpp"
#include "sgraph_slam/core/planes/add_observations.hpp"
#include "sgraph_slam/core/storeys/find_storeys.hpp"
#include "sgraph_slam/core/util/step_clock.hpp"

namespace sgraph {

/// What one keyframe brought.
struct MappingInput {
  Keyframe keyframe;  ///< without its cloud
  KeyframeCloud cloud;
  PlaneSegments segments;
  bool planes;  ///< false: the motion alone
};

/// The steps of mapping, in their order, on a state. One that throws leaves the state as it was half-way: whoever calls goes back to a good one.
class MapBuilder {
 public:
  /// `state` outlives it, and may be set to another between two calls.
  explicit MapBuilder(MapState& state) : state_(state) {}

  /// Continues a map made earlier. `T_map_odom`: where the new session's odometry was found in it, with `covariance`.
  void go_on_with(KeptMap map, const Pose& T_map_odom, const Matrix6& covariance);
  /// Takes a keyframe in: its motion, its planes, and what is then due: solving, loops, merges, places. False when it is refused; then nothing has
  /// changed.
  bool add(const MappingInput& input);
  /// Solves and merges whatever can be, and finds the places; covariances of the planes.
  void optimize();
  /// Keyframes between two solves of the whole graph while nothing returns.
  [[nodiscard]] int due() const;
  /// All solves since the last keyframe came.
  [[nodiscard]] const SolveSummary& last_solve() const { return summary_; }
  [[nodiscard]] KeyframeId newest() const { return committer_.newest(); }
  /// Of the steps since its start, which is the caller's.
  [[nodiscard]] StepClock& clock() { return clock_; }

 private:
  void resume_drift();
  void resume_ride(KeyframeId first);
  void map_planes(const Keyframe& keyframe, const KeyframeCloud& cloud, const PlaneSegments& segments);
  void recognise_storey();
  void update_storeys();
  [[nodiscard]] std::vector<LiftRide> rides() const;
  [[nodiscard]] std::optional<double> storeys_by_lift_known_to() const;
  [[nodiscard]] bool wants_global(const AssociationResult& seen) const;
  [[nodiscard]] bool wants_places() const;
  void note(const SolveSummary& summary);
  void solve_window();
  void solve_global(int iterations, bool all_ghosts);
  void mark_ahead(int storey);
  void merge_planes();
  void merge_until_none(bool all_pairs);
  [[nodiscard]] std::set<int> storeys_by_lift() const;
  void retire_known();
  [[nodiscard]] std::vector<Wall> counted_walls(int storey) const;
  void update_frame();
  void visit(KeyframeId at);
  void take_up_places();
  void update_places(bool measure_all_doors);
  void find_places(bool measure_all_doors);
  [[nodiscard]] std::vector<Eigen::Vector3d> path_on_storey(int storey) const;
  void find_covariances();
  void place_odometry();

  MapState& state_;
  Committer committer_{state_.graph, state_.log};
  SolveSummary summary_;
  StepClock clock_;
};

}  // namespace sgraph
