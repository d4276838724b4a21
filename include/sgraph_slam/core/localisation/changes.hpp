#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/store/stored_map.hpp"

namespace sgraph {

/// What a session found otherwise than those before it.
struct MapChange {
  enum class Kind {
    appeared,  ///< something stands where there was nothing
    gone,      ///< nothing stands where something did
    moved,     ///< both, beside each other and of one size
    wall_new,  ///< long and straight
    wall_gone,
    door_closed,
    door_opened,
  };
  Kind kind = Kind::appeared;
  Eigen::Vector2d center = Eigen::Vector2d::Zero();  ///< seen from above, map frame
  Eigen::Vector2d from = Eigen::Vector2d::Zero();    ///< where it was, of what has moved
  double length = 0;                                 ///< the longer side of what was seen of it [m]
  int storey = 0;
};

/// In words: "door closed: 0.9 m at (1.0, 2.0)".
std::string to_string(const MapChange& change);

/// What a session found changed in the part of the map that it saw again: what stands above the floor where the sessions before saw free space, and
/// the other way round; the newest of them counts. Read from the clouds in the map's file. The longest first; what is shorter than 0.3 m is left out.
std::vector<MapChange> changes_of(const StoredMap& map, std::int64_t session);

}  // namespace sgraph
