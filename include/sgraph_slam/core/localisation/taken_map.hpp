#pragma once

#include <memory>
#include <string>

#include "sgraph_slam/core/localisation/reference_map.hpp"
#include "sgraph_slam/core/mapping/kept_map.hpp"
#include "sgraph_slam/core/store/stored_map.hpp"

namespace sgraph {

/// A map file that a session takes up: read once, never changed.
struct TakenMap {
  std::string path;
  StoredMap stored;  ///< without clouds
  GraphSnapshotPtr snapshot;
  Pose T_base_lidar;  ///< of the robot that made it
  std::shared_ptr<const ReferenceMap> reference;
};

/// Throws StoreError when the file cannot be read, or holds no keyframe.
std::shared_ptr<const TakenMap> take_map(const std::string& path);

/// The map for a back end that goes on with it; its clouds stay in the file. Throws StoreError when its parts do not hang together.
KeptMap kept_map(const TakenMap& map);

}  // namespace sgraph
