#pragma once

#include "sgraph_slam/core/places/find_places.hpp"

namespace sgraph {

/// The openings of the lines that lead from one of the places into another.
std::vector<FoundDoor> find_doors(const std::vector<WallLine>& lines, const FoundPlaces& places, const PlaceParams& params);

}  // namespace sgraph
