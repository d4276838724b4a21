#include "map_builder.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <Eigen/LU>

#include "sgraph_slam/core/graph/solver.hpp"
#include "sgraph_slam/core/loops/close_loop_by_appearance.hpp"
#include "sgraph_slam/core/loops/storey_after_ride.hpp"
#include "sgraph_slam/core/mapping/add_keyframe.hpp"
#include "sgraph_slam/core/places/place_factors.hpp"
#include "sgraph_slam/core/places/topology.hpp"
#include "sgraph_slam/core/planes/align_storeys.hpp"
#include "sgraph_slam/core/planes/drop_planes.hpp"
#include "sgraph_slam/core/planes/level_floors.hpp"
#include "sgraph_slam/core/planes/merge_duplicates.hpp"
#include "sgraph_slam/core/planes/retire_keyframes.hpp"
#include "sgraph_slam/core/planes/tie_stairwells.hpp"
#include "sgraph_slam/core/storeys/find_storeys.hpp"
#include "storey_heights.hpp"

namespace sgraph {
namespace {

constexpr int returns_apart = 5;  // keyframes between two global solves because a place was seen again,
constexpr int returns_share = 2;  // or this part of what is due anyway: in halls something is always seen again
constexpr int marked_ahead = 2;   // keyframes whose rays are marked with each new one: twice as many as come

DominantFrameParams frame_params() { return {}; }

Eigen::Vector2d ground(const Pose& pose) { return pose.translation.head<2>(); }

}  // namespace

void MapBuilder::go_on_with(KeptMap map, const Pose& T_map_odom, const Matrix6& covariance) {
  state_.graph = std::move(map.graph);
  state_.keyframes = std::move(map.keyframes);
  resume_drift();
  state_.planes.map.restore(state_.graph, std::move(map.planes), std::move(map.merged));
  update_frame();
  state_.planes.map.refresh(state_.graph, state_.planes.frame);
  const SceneKeyframe& last = state_.keyframes.rbegin()->second;
  const Pose T_map_odom_before = *state_.graph.find(last.id) * last.T_odom_base.inverse();
  state_.planes.sessions = std::move(map.sessions);
  state_.planes.sessions.insert({last.id.value + 1});
  state_.session = {last.id.value + 1, T_map_odom_before.inverse() * T_map_odom, covariance};
  state_.T_map_odom = T_map_odom;
  update_storeys();
  if (state_.params.topological_layer) take_up_places();
}

bool MapBuilder::add(const MappingInput& input) {
  if (!add_keyframe(state_, input.keyframe, input.cloud)) return false;
  state_.optimized = false;
  summary_ = {};
  clock_.book("keyframe");
  update_storeys();
  clock_.book("storeys");
  if (input.planes) map_planes(input.keyframe, input.cloud, input.segments);
  recognise_storey();
  clock_.book("storeys");
  place_odometry();
  return true;
}

void MapBuilder::optimize() {
  state_.optimized = true;
  summary_ = {};
  solve_global(state_.params.solving.final_iterations, true);
  merge_until_none(true);
  if (state_.params.topological_layer) {
    update_places(false);
    solve_global(state_.params.solving.final_iterations, false);
    merge_until_none(false);
    update_places(true);
  }
  find_covariances();
  clock_.book("covariances");
  place_odometry();
}

int MapBuilder::due() const {
  const SolveParams& params = state_.params.solving;
  return std::max(params.every, static_cast<int>(params.growth * static_cast<double>(state_.keyframes.size())));
}

// How uncertain the odometry of the kept map's keyframes is, as their factors say.
void MapBuilder::resume_drift() {
  std::map<KeyframeId, Matrix6> covariances;
  for (const auto& [id, factor] : state_.graph.factors()) {
    const auto* motion = std::get_if<Se3Between>(&factor.data);
    if (motion == nullptr || motion->source == Se3Between::Source::loop) continue;
    if (motion->source == Se3Between::Source::retired) {  // the motion to the next one holds what is uncertain of the motion to it
      covariances[motion->to] = Matrix6::Zero();
      continue;
    }
    const Matrix6 root = motion->weight.matrix();
    covariances[motion->to] = (root.transpose() * root).inverse();
    if (motion->source == Se3Between::Source::ride) resume_ride(motion->to);
  }
  for (const auto& [id, keyframe] : state_.keyframes) {
    const auto found = covariances.find(id);
    state_.planes.drift.add(id, keyframe.T_odom_base, found != covariances.end() ? found->second : Matrix6::Identity());
  }
}

// A ride of the kept map: whether its storey had been seen before is told by the keyframes before it.
void MapBuilder::resume_ride(KeyframeId first) {
  KeyframeRide ride{first, unknown_rise, true, std::nullopt, true};
  const int storey = state_.keyframes.at(first).storey;
  for (auto before = state_.keyframes.begin(); before->first < first; ++before) {
    if (before->second.storey == storey && storey != stairwell) ride.storey = storey;
  }
  const auto later = [first](const KeyframeRide& other) { return first < other.first; };
  state_.rides.insert(std::find_if(state_.rides.begin(), state_.rides.end(), later), ride);
}

void MapBuilder::map_planes(const Keyframe& keyframe, const KeyframeCloud& cloud, const PlaneSegments& segments) {
  const AssociationResult seen = add_observations(committer_, state_.planes, keyframe, segments);
  clock_.book("association");
  ++state_.since_global;
  ++state_.since_places;
  if (state_.params.solving.window > 0) solve_window();
  clock_.book("solve_newest");
  update_frame();
  if (state_.params.topological_layer) {
    const int storey = state_.planes.storey_of(keyframe.id);
    const CloudPtr points = storey == stairwell ? nullptr : cloud.get();
    if (points) state_.layer.add(keyframe.id, *points, state_.planes.T_base_lidar, storey);
    mark_ahead(storey);
    visit(keyframe.id);
    add_widths(committer_, state_.layer, segments, seen.planes, state_.params.topology);
  }
  clock_.book("visit");
  const bool looped =
      close_loop(committer_, state_.loops, state_.keyframes, state_.planes.drift, state_.planes.marginals) ||
      close_loop_by_appearance(committer_, state_.loops, state_.keyframes, state_.planes.map, state_.planes.drift, state_.planes.marginals);
  clock_.book("loops");
  // One of the three at a time: no keyframe waits for two of them.
  if (state_.merging_due && !looped) {
    merge_planes();
  } else if (looped || wants_global(seen)) {
    solve_global(state_.params.solving.iterations, false);
    state_.merging_due = true;
    if (state_.params.topological_layer && !state_.layer.is_bounded_by(state_.graph)) update_places(false);
  } else if (wants_places()) {
    update_places(false);
  }
}

std::vector<LiftRide> MapBuilder::rides() const {
  std::vector<LiftRide> all;
  for (const KeyframeRide& ride : state_.rides) {
    const auto first = state_.keyframes.find(ride.first);
    if (first != state_.keyframes.end()) all.push_back({static_cast<std::size_t>(std::distance(state_.keyframes.begin(), first)), ride.storey});
  }
  return all;
}

// To what the heights of storeys to which lifts have led are known, standard deviation [m]; none when one of them isn't.
std::optional<double> MapBuilder::storeys_by_lift_known_to() const {
  double variance = 0;
  for (const KeyframeRide& ride : state_.rides) {
    if (ride.rise.sigma >= unknown_rise.sigma) return std::nullopt;
    variance += ride.rise.sigma * ride.rise.sigma;
  }
  return std::sqrt(variance);
}

// After a ride: a storey that was seen before is not another one.
void MapBuilder::recognise_storey() {
  if (state_.rides.empty() || state_.rides.back().settled) return;
  KeyframeRide& ride = state_.rides.back();
  const std::optional<double> sigma = storeys_by_lift_known_to();
  ride.storey = storey_after_ride(committer_, state_.loops, state_.keyframes, ride.first, sigma, ride.settled);
  if (!ride.storey) return;
  update_storeys();
  solve_global(state_.params.solving.iterations, true);
  merge_until_none(true);
}

// Which storey each keyframe and each plane is on; that of the newest keyframes may change while it shows where they lead.
void MapBuilder::update_storeys() {
  std::vector<Eigen::Vector3d> positions;
  for (const auto& [id, keyframe] : state_.keyframes) positions.push_back(state_.graph.find(id)->translation);
  const StoreysOfPath found = find_storeys(positions, rides());
  state_.storey_groups = found.group;
  std::map<KeyframeId, int> storeys;
  bool changed = found.heights.size() != state_.storeys;
  std::size_t i = 0;
  for (auto& [id, keyframe] : state_.keyframes) {
    const int storey = found.storey[i++];
    storeys.emplace_hint(storeys.end(), id, storey);
    if (storey == keyframe.storey) continue;
    keyframe.storey = storey;
    changed = true;
    if (!state_.params.topological_layer || storey == stairwell || id == committer_.newest()) continue;  // the newest one is taken later
    if (const CloudPtr points = keyframe.cloud.get()) state_.layer.add(id, *points, state_.planes.T_base_lidar, storey);
  }
  if (found.heights.size() > state_.storeys && state_.storeys > 0) {
    const std::string above = found.group.back() != 0
                                  ? "a floor of unknown height"
                                  : "a floor " + std::to_string(found.heights.back() - found.heights.front()) + " m above the first";
    state_.log.push_back({committer_.newest(), true, "storey/" + std::to_string(found.heights.size() - 1), above});
  }
  state_.storeys = found.heights.size();
  if (changed) {
    set_storeys(state_.planes, std::move(storeys));
  } else {
    state_.planes.storeys = std::move(storeys);
  }
}

bool MapBuilder::wants_global(const AssociationResult& seen) const {
  const int whole = due();
  if (state_.since_global >= whole) return true;
  return state_.since_global >= std::max(returns_apart, whole / returns_share) && (seen.returned || !state_.pending_merges.empty());
}

// Places are found anew in a graph that was just solved, as rarely as the whole graph is when nothing returns.
bool MapBuilder::wants_places() const {
  return state_.params.topological_layer && state_.since_global < state_.since_places && state_.since_places >= due();
}

void MapBuilder::note(const SolveSummary& summary) {
  const double before = summary_.milliseconds;
  summary_ = summary;
  summary_.milliseconds += before;
}

void MapBuilder::solve_window() {
  SolverOptions options;
  options.max_iterations = state_.params.solving.window_iterations;
  note(state_.recent.solve(state_.graph, state_.params.solving.window, options));
}

// The storeys whose height against the first is unknown.
std::set<int> MapBuilder::storeys_by_lift() const {
  std::set<int> storeys;
  for (std::size_t k = 0; k < state_.storey_groups.size(); ++k) {
    if (state_.storey_groups[k] != 0) storeys.insert(static_cast<int>(k));
  }
  return storeys;
}

void MapBuilder::solve_global(int iterations, bool all_ghosts) {
  drop_passing_planes(committer_, state_.planes, all_ghosts);
  if (state_.params.factors.storey_factors) {
    level_floors(committer_, state_.planes.map, storeys_by_lift());
    tie_stairwells(committer_, state_.planes.map);
    lift_floors(committer_, state_);
    align_storeys(committer_, state_.planes.map, known_heights(state_));
  }
  clock_.book("drop_planes");
  SolverOptions options;
  options.max_iterations = iterations;
  note(solve(state_.graph, options));
  clock_.book("solve");
  state_.since_global = 0;
  state_.solved = committer_.newest();
  retire_known();
  clock_.book("retire");
  state_.planes.marginals.forget();
  state_.planes.map.refresh(state_.graph, state_.planes.frame);
  update_frame();
  clock_.book("extents");
}

// Planes that turn out to be one now that the whole graph has been solved. It was with the keyframe before, so that no keyframe waits for both.
void MapBuilder::merge_planes() {
  state_.merging_due = false;
  std::set<PlanePair> shown;
  shown.swap(state_.pending_merges);
  merge_once(committer_, state_.planes, shown, state_.params.solving.iterations);
  clock_.book("merge");
}

// The same where nobody waits for a keyframe: the whole graph is solved with them. `all_pairs`: those too that were found apart lately.
void MapBuilder::merge_until_none(bool all_pairs) {
  state_.merging_due = false;
  std::set<PlanePair> shown;
  shown.swap(state_.pending_merges);
  merge_duplicates(committer_, state_.planes, shown, all_pairs, state_.params.solving.iterations);
  clock_.book("merge");
}

// Those that the solves of the newest part leave alone, of the session that is going on: another one may be taken out of the map again.
void MapBuilder::retire_known() {
  const auto& poses = state_.graph.keyframes();
  const auto window = static_cast<std::size_t>(state_.params.solving.window);
  if (poses.size() <= window) return;
  const KeyframeId end = std::prev(poses.end(), static_cast<std::ptrdiff_t>(window) + 1)->first;
  const std::vector<KeyframeId> retired = retire_keyframes(committer_, state_.planes, {state_.session.first}, end);
  for (const KeyframeId id : clouds_to_let_go(state_.graph, state_.retired_with_clouds, retired)) {
    state_.keyframes.at(id).cloud = nullptr;
    state_.clouds_let_go.push_back(id);
  }
}

// What is too low or has been seen too rarely bounds no place.
std::vector<Wall> MapBuilder::counted_walls(int storey) const {
  return state_.planes.map.walls(static_cast<std::size_t>(state_.params.topology.min_views), state_.params.topology.min_height, storey);
}

void MapBuilder::update_frame() {
  if (!state_.params.semantics.dominant_frame) {
    state_.planes.frame = {0, 1};
    return;
  }
  state_.planes.frame = estimate_dominant_frame(wall_directions(state_.planes.map), state_.planes.frame, frame_params());
}

// The rays of keyframes that have been solved with the whole graph: they will hardly move any more.
void MapBuilder::mark_ahead(int storey) {
  const auto settled = [&](KeyframeId id) -> const Pose* {
    if (!state_.solved.valid() || state_.solved < id || state_.planes.storey_of(id) != storey) return nullptr;
    return state_.graph.find(id);
  };
  if (storey != stairwell) state_.layer.mark_ahead(storey, settled, marked_ahead);
}

// Planes that the place around the robot shows to be one wall, if they haven't been found apart lately.
void MapBuilder::visit(KeyframeId at) {
  if (!state_.params.merging.by_places) return;
  const int storey = state_.planes.storey_of(at);
  for (const PlanePair& pair : state_.layer.shown_at(counted_walls(storey), ground(*state_.graph.find(at)), at, storey)) {
    if (!state_.planes.found_apart_lately(pair, at) && state_.planes.refused_merges.count(pair) == 0) state_.pending_merges.insert(pair);
  }
}

// The places of a map made earlier, from its walls and its keyframes' clouds.
void MapBuilder::take_up_places() {
  for (const auto& [id, keyframe] : state_.keyframes) {
    const CloudPtr points = keyframe.storey == stairwell ? nullptr : keyframe.cloud.get();
    if (points) state_.layer.add(id, *points, state_.planes.T_base_lidar, keyframe.storey);
  }
  update_places(true);
}

void MapBuilder::update_places(bool measure_all_doors) {
  state_.since_places = 0;
  find_places(measure_all_doors);
  clock_.book("places");
  synchronise(committer_, state_.layer, state_.planes.map, state_.params.topology);
  add_wall_faces(committer_, state_.planes.map, state_.params.merging.max_angle, state_.params.topology);
  state_.openings.clear();
  for (const auto& [number, heights] : state_.layer.storeys()) {
    for (SceneOpening& opening : find_openings(state_.layer.places(number), path_on_storey(number))) state_.openings.push_back(std::move(opening));
  }
  clock_.book("topology");
}

void MapBuilder::find_places(bool measure_all_doors) {
  const std::size_t count = std::max<std::size_t>(1, state_.storeys);
  std::vector<std::vector<Eigen::Vector2d>> paths(count);
  std::vector<std::vector<Wall>> walls(count);
  std::vector<Survey> surveys;
  for (std::size_t k = 0; k < count; ++k) {
    const int number = static_cast<int>(k);
    for (const Eigen::Vector3d& p : path_on_storey(number)) paths[k].push_back(p.head<2>());
    walls[k] = counted_walls(number);
    std::map<KeyframeId, Pose> on_it;
    for (const auto& [id, keyframe] : state_.keyframes) {
      if (keyframe.storey == number) on_it.emplace_hint(on_it.end(), id, *state_.graph.find(id));
    }
    const StoreyHeights heights = find_storey(state_.graph, state_.planes.map, on_it, number);
    surveys.push_back({walls[k], paths[k], heights, state_.planes.frame.yaw, committer_.newest(), measure_all_doors, number, std::move(on_it)});
  }
  state_.layer.find(state_.graph, surveys, state_.log);
}

// Of the base, every scan taken on a storey.
std::vector<Eigen::Vector3d> MapBuilder::path_on_storey(int storey) const {
  std::vector<Eigen::Vector3d> path;
  for (const auto& [id, keyframe] : state_.keyframes) {
    if (keyframe.storey != storey) continue;
    const Pose T_map_odom = *state_.graph.find(id) * keyframe.T_odom_base.inverse();
    for (const StampedPose& scan : *keyframe.scans) path.push_back((T_map_odom * scan.pose).translation);
    if (keyframe.scans->empty()) path.push_back(state_.graph.find(id)->translation);
  }
  return path;
}

void MapBuilder::find_covariances() {
  const Marginals* marginals = state_.planes.marginals.get(state_.graph, 0);
  if (!marginals) return;
  state_.plane_covariances.clear();
  for (const auto& [id, plane] : state_.graph.planes()) {
    if (const auto covariance = marginals->covariance(id)) state_.plane_covariances[id] = *covariance;
  }
}

void MapBuilder::place_odometry() {
  const SceneKeyframe& newest = state_.keyframes.rbegin()->second;
  state_.T_map_odom = *state_.graph.find(newest.id) * newest.T_odom_base.inverse() * state_.session.T_odom_own;
}

}  // namespace sgraph
