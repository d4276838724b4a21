#pragma once

#include <map>
#include <vector>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/mapping/map_state.hpp"

namespace sgraph {

/// Sets the floors of two storeys as far apart as a ride in a lift between them was measured to be, once both floors have been seen. A cabin stops at
/// the floor's height, to a centimetre. A floor that turns out to be another storey's takes that along when it is merged.
void lift_floors(Committer& committer, MapState& state);

/// To what the storeys' heights are known, standard deviations [m]: 0 where stairs lead to one from the first, else what the measured rides on the
/// way add up to; those of which nothing told it aren't there.
std::map<int, double> storey_height_sigmas(const MapState& state);

/// A number for each storey; the heights of those with the same one are known against each other, by stairs or by measured rides.
std::vector<int> known_heights(const MapState& state);

}  // namespace sgraph
