#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// The S-Graph for rviz, its layers `layer_height` [m] apart so that they can be told from each other: keyframes and the way between them where they
/// are; planes as polygons above (small ones that bound no place, furniture for the most part, as thin outlines in the namespace `small_planes`) and
/// doors in them; rooms and corridors as nodes on top, with names and sizes and a line to each of their walls and doors; of a building with several
/// storeys a node a storey above these. Begins with a marker that deletes what an earlier message drew.
visualization_msgs::MarkerArray graph_markers(const GraphSnapshot& snapshot, double layer_height);

/// Sends of a drawing what has changed since the one before: a map grows at one place and stays as it is elsewhere.
class MarkerChanges {
 public:
  /// Of a whole drawing: all of it when `whole`; else the markers that are new or look another way by more than a centimetre, and deletions of those
  /// that are gone. Empty when nothing changed.
  visualization_msgs::MarkerArray since_last(const visualization_msgs::MarkerArray& drawing, bool whole);

 private:
  std::map<std::pair<std::string, int>, std::uint64_t> sent_;  // what each marker looked like
};

}  // namespace sgraph
