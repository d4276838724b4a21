#pragma once

#include <vector>

#include "sgraph_slam/core/graph/committer.hpp"
#include "sgraph_slam/core/places/topological_layer.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"
#include "sgraph_slam/core/types/segments.hpp"

namespace sgraph {

/// Widths that the newest keyframe saw of the rooms and corridors whose facing walls it saw both. `planes`: of each of its segments the plane that it
/// was taken for, as association says.
void add_widths(Committer& committer, const TopologicalLayer& layer, const PlaneSegments& segments, const std::vector<PlaneId>& planes,
                const TopologyParams& params);

/// The two faces of walls: as far apart as those of the building's other walls, and parallel within `max_angle` [rad].
void add_wall_faces(Committer& committer, const PlaneMap& planes, double max_angle, const TopologyParams& params);

/// Brings the graph's rooms and corridors in line with the layer and their constants with the walls.
void synchronise(Committer& committer, const TopologicalLayer& layer, const PlaneMap& planes, const TopologyParams& params);

}  // namespace sgraph
