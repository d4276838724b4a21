#include "sgraph_slam/core/planes/merge_duplicates.hpp"

#include <algorithm>
#include <iomanip>
#include <sstream>

#include "sgraph_slam/core/graph/solver.hpp"

namespace sgraph {
namespace {

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
std::vector<Merged> merge_step(Committer& committer, PlaneLayer& planes, const std::set<PlanePair>& candidates, const std::set<PlanePair>& shown) {
  const MergeParams& params = planes.params.merging;
  std::vector<Merged> done;
  // Most pairs have been seen apart, which takes no covariances of the whole graph to know.
  std::vector<PlanePair> open;
  for (const PlanePair& pair : candidates) {
    if (seen_apart(committer.graph, *planes.map.find(pair.first), *planes.map.find(pair.second), params.chi_square)) {
      planes.tested_merges[pair] = committer.newest();
    } else {
      open.push_back(pair);
    }
  }
  if (open.empty()) return done;
  const Marginals* marginals = planes.marginals.get(committer.graph, 0);
  if (!marginals) return done;
  std::vector<std::pair<double, PlanePair>> within;
  for (const PlanePair& pair : open) {
    const auto chi_square = merge_chi_square(committer.graph, planes.map, *marginals, pair, params);
    const double gate = params.chi_square * (shown.count(pair) > 0 ? shown_gain : 1);
    if (chi_square && *chi_square < gate) {
      within.emplace_back(*chi_square, pair);
    } else if (chi_square) {  // what association asked for doesn't know the newest keyframe's own planes: they can wait
      planes.tested_merges[pair] = committer.newest();
    }
  }
  std::sort(within.begin(), within.end());
  std::set<PlaneId> busy;
  for (const auto& [chi_square, pair] : within) {
    if (busy.count(pair.first) > 0 || busy.count(pair.second) > 0) continue;
    const double before = mean_observation_error(committer.graph, {pair.first, pair.second});
    Transaction edit;
    edit.reason = merge_name(pair);
    edit.merges.push_back({pair.first, pair.second});
    if (!committer.commit(edit).ok()) continue;
    planes.map.merge(committer.graph, pair.first, pair.second);
    busy.insert(pair.first);
    busy.insert(pair.second);
    committer.note(true, edit.reason, text("chi-square ", chi_square, shown.count(pair) > 0 ? ", one wall of a place seen again" : ""));
    done.push_back({pair, before});
  }
  return done;
}

// Whether the views of a merged plane fit worse than they did.
bool is_misfit(const Graph& graph, const Merged& merge, const MergeParams& params, double* after) {
  *after = mean_observation_error(graph, {merge.pair.first});
  return *after > params.max_error && *after > params.max_growth * merge.error_before;
}

// Undoes the merges whose planes' views fit worse than they did; true when there were any.
bool undo_misfits(Committer& committer, PlaneLayer& planes, std::vector<Merged>& done) {
  bool any = false;
  for (auto merge = done.begin(); merge != done.end();) {
    double after = 0;
    if (!is_misfit(committer.graph, *merge, planes.params.merging, &after)) {
      ++merge;
      continue;
    }
    Transaction edit;
    edit.reason = "undo: " + merge_name(merge->pair);
    edit.undo_merges.push_back(merge->pair.second);
    if (committer.commit(edit).ok()) {
      planes.map.undo_merge(committer.graph, merge->pair.first, merge->pair.second);
      planes.refused_merges.insert(merge->pair);
      committer.note(false, merge_name(merge->pair),
                     text("undone: mean chi-square of its views ", merge->error_before, " before, ", after, " after"));
      any = true;
    }
    merge = done.erase(merge);
  }
  return any;
}

std::set<PlanePair> pairs_to_try(const Committer& committer, const PlaneLayer& planes, const std::set<PlanePair>& shown, bool all) {
  std::set<PlanePair> candidates;
  for (const PlanePair& pair : merge_candidates(committer.graph, planes.map, planes.params.merging, planes.params.association.extent_margin)) {
    if (all || !planes.found_apart_lately(pair, committer.newest())) candidates.insert(pair);
  }
  for (const PlanePair& pair : shown) {
    if (committer.graph.find(pair.first) && committer.graph.find(pair.second)) candidates.insert(pair);
  }
  for (const PlanePair& pair : planes.refused_merges) candidates.erase(pair);
  return candidates;
}

}  // namespace

int merge_duplicates(Committer& committer, PlaneLayer& planes, const std::set<PlanePair>& shown_by_places, bool all, int iterations) {
  if (!planes.params.merging.enabled) return 0;
  int count = 0;
  for (int round = 0; round < 3; ++round) {
    const std::set<PlanePair> candidates = pairs_to_try(committer, planes, shown_by_places, all && round == 0);
    if (candidates.empty()) break;
    std::vector<Merged> done = merge_step(committer, planes, candidates, shown_by_places);
    if (done.empty()) break;
    SolverOptions options;
    options.max_iterations = iterations;
    solve(committer.graph, options);
    if (undo_misfits(committer, planes, done)) solve(committer.graph, options);
    planes.marginals.forget();
    planes.map.refresh(committer.graph, planes.frame);
    count += static_cast<int>(done.size());
  }
  return count;
}

int merge_once(Committer& committer, PlaneLayer& planes, const std::set<PlanePair>& shown_by_places, int iterations) {
  if (!planes.params.merging.enabled) return 0;
  const std::set<PlanePair> candidates = pairs_to_try(committer, planes, shown_by_places, false);
  std::vector<Merged> done = merge_step(committer, planes, candidates, shown_by_places);
  if (done.empty()) return 0;
  SolverOptions options;
  options.max_iterations = iterations;
  SolveScope merged;
  merged.free.emplace();
  for (const Merged& merge : done) merged.free->insert(merge.pair.first);
  solve(committer.graph, options, merged);
  double after = 0;
  const auto misfits = [&](const Merged& merge) { return is_misfit(committer.graph, merge, planes.params.merging, &after); };
  if (std::any_of(done.begin(), done.end(), misfits)) {
    solve(committer.graph, options);
    if (undo_misfits(committer, planes, done)) solve(committer.graph, options);
    planes.marginals.forget();
  }
  planes.map.refresh(committer.graph, planes.frame);
  return static_cast<int>(done.size());
}

}  // namespace sgraph
