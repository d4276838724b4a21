#pragma once

#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/store/stored_map.hpp"

namespace sgraph {

/// A piece of wall, door or large furniture that a session found otherwise than those before it.
struct MapChange {
  bool appeared = true;                              ///< false: it is gone
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  ///< seen from above, level frame of the map
  double length = 0;                                 ///< [m]
};

/// What a session found changed in the part of the map that it saw again: faces where there was free space, free space where there was a face. Sorted
/// by length, the longest first. Pieces shorter than 0.5 m are left out: they are clutter.
std::vector<MapChange> changes_of(const StoredMap& map, std::int64_t session);

}  // namespace sgraph
