#include <iomanip>
#include <sstream>

#include "sgraph_slam/core/graph/solver.hpp"
#include "sgraph_slam/core/mapping/map_state.hpp"
#include "sgraph_slam/core/planes/merging.hpp"

namespace sgraph {
namespace {

constexpr int try_again = 40;     // keyframes until a pair that was found apart is tried again
constexpr double shown_gain = 4;  // a place that is seen to be the same widens the gate

std::string merge_name(PlanePair pair) {
  return "merge plane/" + std::to_string(pair.second.value) + " into plane/" + std::to_string(pair.first.value);
}

template <class... Parts>
std::string text(const Parts&... parts) {
  std::ostringstream stream;
  stream << std::setprecision(3);
  (stream << ... << parts);
  return stream.str();
}

struct Merged {
  PlanePair pair;
  double error_before;
};

// Pairs within their gate, the surest first; a plane takes part in one merge at a time.
std::vector<Merged> merge_step(MapState& state, const std::set<PlanePair>& candidates, const std::set<PlanePair>& shown) {
  const MergeParams& params = state.params.merging;
  std::vector<Merged> done;
  const Marginals* marginals = state.marginals.get(state.graph, 0);
  if (!marginals) return done;
  std::vector<std::pair<double, PlanePair>> within;
  for (const PlanePair& pair : candidates) {
    const auto chi_square = merge_chi_square(state.graph, state.planes, *marginals, pair, params);
    const double gate = params.chi_square * (shown.count(pair) > 0 ? shown_gain : 1);
    if (chi_square && *chi_square < gate &&
        !seen_apart(state.graph, *state.planes.find(pair.first), *state.planes.find(pair.second), params.chi_square)) {
      within.emplace_back(*chi_square, pair);
    } else {
      state.tested_merges[pair] = state.newest();
    }
  }
  std::sort(within.begin(), within.end());
  std::set<PlaneId> busy;
  for (const auto& [chi_square, pair] : within) {
    if (busy.count(pair.first) > 0 || busy.count(pair.second) > 0) continue;
    const double before = mean_observation_error(state.graph, {pair.first, pair.second});
    Transaction edit;
    edit.reason = merge_name(pair);
    edit.merges.push_back({pair.first, pair.second});
    if (!commit(state, edit).ok()) continue;
    state.planes.merge(state.graph, pair.first, pair.second);
    busy.insert(pair.first);
    busy.insert(pair.second);
    state.log.push_back(
        {state.newest(), true, edit.reason, text("chi-square ", chi_square, shown.count(pair) > 0 ? ", one wall of a place seen again" : "")});
    done.push_back({pair, before});
  }
  return done;
}

// Undoes the merges whose planes' views fit worse than they did; true when there were any.
bool undo_misfits(MapState& state, std::vector<Merged>& done) {
  bool any = false;
  for (auto merge = done.begin(); merge != done.end();) {
    const double after = mean_observation_error(state.graph, {merge->pair.first});
    if (after <= state.params.merging.max_error || after <= state.params.merging.max_growth * merge->error_before) {
      ++merge;
      continue;
    }
    Transaction edit;
    edit.reason = "undo: " + merge_name(merge->pair);
    edit.undo_merges.push_back(merge->pair.second);
    if (commit(state, edit).ok()) {
      state.planes.undo_merge(state.graph, merge->pair.first, merge->pair.second);
      state.refused_merges.insert(merge->pair);
      state.log.push_back({state.newest(), false, merge_name(merge->pair),
                           text("undone: mean chi-square of its views ", merge->error_before, " before, ", after, " after")});
      any = true;
    }
    merge = done.erase(merge);
  }
  return any;
}

}  // namespace

int merge_duplicates(MapState& state, const std::set<PlanePair>& shown_by_places, bool all) {
  if (!state.params.merging.enabled) return 0;
  int count = 0;
  for (int round = 0; round < 3; ++round) {
    std::set<PlanePair> candidates;
    for (const PlanePair& pair : merge_candidates(state.graph, state.planes, state.params.merging, state.params.association.extent_margin)) {
      const auto tested = state.tested_merges.find(pair);
      const bool lately = tested != state.tested_merges.end() && state.newest().value - tested->second.value < try_again;
      if (!lately || (all && round == 0)) candidates.insert(pair);
    }
    for (const PlanePair& pair : shown_by_places) {
      if (state.graph.find(pair.first) && state.graph.find(pair.second)) candidates.insert(pair);
    }
    for (const PlanePair& pair : state.refused_merges) candidates.erase(pair);
    if (candidates.empty()) break;
    std::vector<Merged> done = merge_step(state, candidates, shown_by_places);
    if (done.empty()) break;
    SolverOptions options;
    options.max_iterations = state.params.solving.iterations;
    solve(state.graph, options);
    if (undo_misfits(state, done)) solve(state.graph, options);
    state.marginals.forget();
    state.planes.refresh(state.graph, state.frame);
    count += static_cast<int>(done.size());
  }
  return count;
}

}  // namespace sgraph
