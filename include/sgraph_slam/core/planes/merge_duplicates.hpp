#pragma once

#include <set>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/planes/plane_layer.hpp"

namespace sgraph {

/// Merges planes that are one surface by their marginals, more readily those that a place shows to be one; solves, with at most `iterations`; undoes
/// what doesn't fit. Pairs found apart lately are not tried again unless `all`. Returns how many were merged and kept.
int merge_duplicates(Committer& committer, PlaneLayer& planes, const std::set<PlanePair>& shown_by_places, bool all, int iterations);

/// One round of that for a graph that was just solved and will be solved again soon: only the planes that are merged are solved, each from where its
/// keyframes stand, and the whole graph only when a merged plane doesn't fit so. Which pairs are tried is as with `merge_duplicates`.
int merge_once(Committer& committer, PlaneLayer& planes, const std::set<PlanePair>& shown_by_places, int iterations);

}  // namespace sgraph
