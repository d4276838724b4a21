#pragma once

#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/ids.hpp"

namespace sgraph {

/// Where the clouds of keyframes are while nobody works on them: a file, a database. Memory is then bounded by what is being worked on. All functions
/// may be called from any thread.
class KeyframeClouds {
 public:
  virtual ~KeyframeClouds() = default;

  /// Keeps the cloud of a keyframe, points in the LiDAR's frame; replaces one put earlier. Never loses it: where it can't be written (no space left) it
  /// stays in memory, and whoever owns the store reports that.
  virtual void put(KeyframeId id, const CloudPtr& cloud) = 0;

  /// The cloud as it was put, viewpoints included; null when there is none, or when it can't be read any more.
  [[nodiscard]] virtual CloudPtr get(KeyframeId id) const = 0;
};

}  // namespace sgraph
