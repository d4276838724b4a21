#pragma once

#include <optional>
#include <vector>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/mapping/map_state.hpp"

namespace sgraph {

/// Sets the floors of two storeys as far apart as a ride in a lift between them was measured to be, once both floors have been seen. A cabin stops at
/// the floor's height, to a centimetre. A floor that turns out to be another storey's takes that along when it is merged.
void lift_floors(Committer& committer, MapState& state);

/// To what a storey's height is known, standard deviation [m]: 0 where stairs lead to it from the first one, else what the measured rides on the way
/// add up to; none where nothing told it.
std::optional<double> storey_height_sigma(const MapState& state, int storey);

/// A number for each storey; the heights of those with the same one are known against each other, by stairs or by measured rides.
std::vector<int> known_heights(const MapState& state);

}  // namespace sgraph
