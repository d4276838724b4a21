#pragma once

#include "sgraph_slam/core/mapping/map_state.hpp"

namespace sgraph {

/// The whole state as readers see it; `with_factors`: the factors serialised, the views of the planes and the decisions too, which takes time.
GraphSnapshotPtr make_snapshot(const MapState& state, std::int64_t version, const SolveSummary& solve, bool with_factors);

}  // namespace sgraph
