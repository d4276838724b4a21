#pragma once

#include <string>

#include "sgraph_slam/core/search/place_search.hpp"

namespace sgraph {

/// What a place must show to be believed.
struct PlaceVerdict {
  bool stands = false;  ///< the best place: enough of what was seen matches, and little contradicts
  int possible = 0;     ///< places that cannot be ruled out, the best among them
  bool enough = false;  ///< enough wall was seen, and it holds the position in both directions

  /// One place, and only one, agrees with all that was seen.
  [[nodiscard]] bool believed() const { return stands && possible == 1 && enough; }
};

/// Judges the places that a search found. `share`: of the wall that must have been seen, less than 1 when somebody told where the robot is.
PlaceVerdict judge_places(const PlaceSearchResult& places, const Layout& query, double share = 1);

/// In words: lengths of wall.
std::string to_string(const LayoutFit& fit);

}  // namespace sgraph
