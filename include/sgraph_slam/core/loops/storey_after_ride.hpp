#pragma once

#include <map>
#include <optional>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/loops/close_loop.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// Whether the storey on which a ride in a lift ended has been seen before. Place and heading are kept in a lift, so what was seen around its door on
/// each storey, the one that was left included, is laid over what is seen now: on the same storey the walls agree. The match then joins the two, and
/// the storey's number is returned. `first`: the first keyframe after the ride; `settled` is set when there is nothing more to wait for. `sigma`: to
/// what the height of `first` is known against the other storeys, standard deviation [m]; those that are farther from it aren't asked. None: not at
/// all.
std::optional<int> storey_after_ride(Committer& committer, const LoopCloser& loops, const std::map<KeyframeId, SceneKeyframe>& keyframes,
                                     KeyframeId first, std::optional<double> sigma, bool& settled);

}  // namespace sgraph
