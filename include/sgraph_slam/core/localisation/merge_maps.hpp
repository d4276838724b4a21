#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/localisation/mapping_session.hpp"
#include "sgraph_slam/core/store/stored_map.hpp"

namespace sgraph {

/// The keyframes of one session of a map file with the planes that they saw, as the map kept them. Odometry in the session's own frame.
std::vector<LocatedKeyframe> located_keyframes(const StoredMap& map, std::int64_t session);

/// Adds a session to the map in `into`, in the file `out` (the same or a new one); without `into` it begins a map. `near`: T_map_base of its first
/// keyframe, when that is known; else its place is searched for. Returns how its place was found; `not_found` or `ambiguous`: the map is as it was.
/// Clouds that `from` doesn't hold are read from its file, one at a time. Throws StoreError.
Localisation add_session(const StoredMap& from, std::int64_t session, const std::string& into, const std::string& out,
                         const std::optional<Pose>& near, const MappingParams& params);

}  // namespace sgraph
