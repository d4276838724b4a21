#pragma once

#include <set>
#include <vector>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/planes/plane_layer.hpp"

namespace sgraph {

/// Retires keyframes before `end` that say nothing new about the map, so that factors and views of planes grow with the area and not with the time
/// spent in it. One goes when `FactorParams::spot_keyframes` older ones of the session (from `first` on) stand at the same spot and show most of the
/// planes that it shows: from one spot the errors that beams and surfaces give are the same, and more views don't average them out. It keeps its
/// pose, beside the one of them that shows most of its planes (`Se3Between::Source::retired`), which also takes over what few others show. The
/// odometry to it and from it becomes one factor past it. Keyframes that loops hold stay. Each keyframe is asked once. Returns those that were
/// retired. Source: design, Cost ("redundant keyframes retired, their information kept").
std::vector<KeyframeId> retire_keyframes(Committer& committer, PlaneLayer& planes, KeyframeId first, KeyframeId end);

/// Which retired keyframes' clouds nobody needs any more, so that clouds grow with the area too: of those at one spot the newest four keep theirs
/// (they show what has been moved since the others were taken), beside the ones that aren't retired. `with_clouds`: retired ones that had theirs so
/// far; `newly`: retired since. Takes the answer out of `with_clouds`.
std::vector<KeyframeId> clouds_to_let_go(const Graph& graph, std::set<KeyframeId>& with_clouds, const std::vector<KeyframeId>& newly);

/// Standard deviations of a retired keyframe's pose beside the one that it hangs on (rotation [rad], translation [m]): what no motion between
/// keyframes is taken to be known better than.
Vector6 retired_sigma(const FactorParams& params);

}  // namespace sgraph
