#pragma once

#include "sgraph_slam/core/loops/params.hpp"
#include "sgraph_slam/core/params/visitor.hpp"
#include "sgraph_slam/core/places/params.hpp"
#include "sgraph_slam/core/planes/params.hpp"

namespace sgraph {

/// When the graph is solved, and how.
struct SolveParams {
  int window = 8;
  int window_iterations = 4;
  int every = 10;
  double growth = 0.05;
  int iterations = 20;
  int final_iterations = 100;

  void describe(ParamVisitor& v) {
    v.field("window", window, "", {0, 1000}, "Newest keyframes solved at each keyframe, with the planes they see; 0: none.");
    v.field("window_iterations", window_iterations, "", {1, 100}, "At most this many iterations.");
    v.field("every", every, "", {1, 10000}, "The whole graph is solved at least after this many keyframes ...");
    v.field("growth", growth, "", {0, 1},
            "... or this share of all keyframes, whichever is more; and at once after a merge, a loop or a return to a place.");
    v.field("iterations", iterations, "", {1, 1000}, "At most this many iterations of it.");
    v.field("final_iterations", final_iterations, "", {1, 10000}, "At most this many when the whole graph is optimised on demand.");
  }
};

struct MappingParams {
  bool topological_layer = true;
  FactorParams factors;
  AssociationParams association;
  SemanticsParams semantics;
  MergeParams merging;
  TopologyParams topology;
  PlaceParams places;
  FreeSpaceParams free_space;
  LoopParams loops;
  SolveParams solving;

  void describe(ParamVisitor& v) {
    v.field("topological_layer", topological_layer, "Rooms and corridors; off: the paper's \"w/o top. layer\".");
    v.group("factors", factors, "Weights and losses of the odometry's and the planes' factors.");
    v.group("association", association, "When a segment is a new view of a plane of the map.");
    v.group("semantics", semantics, "Axes of the building and classes of planes.");
    v.group("merging", merging, "Planes that turn out to be one.");
    v.group("topology", topology, "Factors of rooms and corridors.");
    v.group("places", places, "What bounds and parts places.");
    v.group("free_space", free_space, "The raster of free floor on which places are found.");
    v.group("loops", loops, "Loop closure by scan matching.");
    v.group("solving", solving, "When the graph is solved, and how.");
  }
};

}  // namespace sgraph
