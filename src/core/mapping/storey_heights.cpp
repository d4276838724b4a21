#include "storey_heights.hpp"

#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <utility>

#include "sgraph_slam/core/graph/factors/aligned_walls.hpp"
#include "sgraph_slam/core/planes/level_floors.hpp"
#include "sgraph_slam/core/types/storey.hpp"

namespace sgraph {
namespace {

constexpr double stops = 0.01;  // [m] to which a cabin stops at a floor

// The storey on which a ride began: of the last keyframe before it that wasn't on stairs.
int storey_before(const MapState& state, KeyframeId first) {
  for (auto keyframe = state.keyframes.find(first); keyframe != state.keyframes.begin();) {
    --keyframe;
    if (keyframe->second.storey != stairwell) return keyframe->second.storey;
  }
  return stairwell;
}

int group_of(const MapState& state, int storey) {
  const auto k = static_cast<std::size_t>(storey);
  return k < state.storey_groups.size() ? state.storey_groups[k] : 0;
}

// Of the groups within which stairs lead everywhere, against the first one's, standard deviation [m].
std::map<int, double> group_sigmas(const MapState& state) {
  if (state.rides.empty()) return {{0, 0.0}};
  std::map<std::pair<int, int>, double> information;  // of the height between two groups, from all rides between them
  for (const auto& [id, factor] : state.graph.factors()) {
    const auto* floors = std::get_if<AlignedWalls>(&factor.data);
    if (floors == nullptr || !are_floors_apart(*floors)) continue;
    const PlaneRecord* a = state.planes.map.find(floors->a);
    const PlaneRecord* b = state.planes.map.find(floors->b);
    if (a == nullptr || b == nullptr || a->storey == stairwell || b->storey == stairwell) continue;
    for (const auto& pair : {std::pair(a->storey, b->storey), std::pair(b->storey, a->storey)}) {
      information[{group_of(state, pair.first), group_of(state, pair.second)}] += 1 / (floors->shift_sigma * floors->shift_sigma);
    }
  }
  std::map<int, double> sigmas{{0, 0.0}};
  for (bool more = true; more;) {
    more = false;
    for (const auto& [pair, weight] : information) {
      const auto from = sigmas.find(pair.first);
      if (from == sigmas.end()) continue;
      const double sigma = std::hypot(from->second, 1 / std::sqrt(weight));
      const auto to = sigmas.emplace(pair.second, sigma);
      if (!to.second && to.first->second <= sigma) continue;
      to.first->second = sigma;
      more = true;
    }
  }
  return sigmas;
}

}  // namespace

void lift_floors(Committer& committer, MapState& state) {
  for (KeyframeRide& ride : state.rides) {
    if (ride.placed || ride.rise.sigma >= unknown_rise.sigma) continue;
    const auto first = state.keyframes.find(ride.first);
    if (first == state.keyframes.end()) continue;
    const int from = storey_before(state, ride.first);
    const int to = first->second.storey;
    if (from == stairwell || to == stairwell || from == to) continue;
    const std::optional<PlaneId> below = largest_floor(state.graph, state.planes.map, from);
    const std::optional<PlaneId> above = largest_floor(state.graph, state.planes.map, to);
    if (!below || !above) continue;
    const Eigen::Vector3d at = state.graph.find(ride.first)->translation;
    Transaction edit;
    edit.reason = "a lift's floors are as far apart as the ride was long";
    add_factor(edit, at_height(*below, *above, at, ride.rise.height, std::hypot(ride.rise.sigma, stops)));
    ride.placed = committer.commit(edit).ok();
  }
}

std::map<int, double> storey_height_sigmas(const MapState& state) {
  const std::map<int, double> sigmas = group_sigmas(state);
  std::map<int, double> known;
  for (const auto& [storey, space] : state.layer.storeys()) {
    const auto found = sigmas.find(group_of(state, storey));
    if (found != sigmas.end()) known[storey] = found->second;
  }
  return known;
}

std::vector<int> known_heights(const MapState& state) {
  const std::map<int, double> sigmas = group_sigmas(state);
  std::set<int> measured;
  for (const auto& [group, sigma] : sigmas) measured.insert(group);
  for (const KeyframeRide& ride : state.rides) {  // those whose floors are still to be set apart
    const auto first = state.keyframes.find(ride.first);
    if (first == state.keyframes.end() || ride.rise.sigma >= unknown_rise.sigma) continue;
    if (measured.count(group_of(state, storey_before(state, ride.first))) > 0) measured.insert(group_of(state, first->second.storey));
  }
  std::vector<int> known = state.storey_groups;
  for (int& group : known) {
    if (measured.count(group) > 0) group = 0;
  }
  return known;
}

}  // namespace sgraph
