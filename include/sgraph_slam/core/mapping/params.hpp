#pragma once

#include "sgraph_slam/core/loops/params.hpp"
#include "sgraph_slam/core/params/visitor.hpp"
#include "sgraph_slam/core/places/params.hpp"
#include "sgraph_slam/core/planes/params.hpp"

namespace sgraph {

/// Motions between keyframes measured by their scans where the odometry is poor.
struct SubmapParams {
  bool enabled = true;
  double min_sigma = 0.01;
  double leaf = 0.2;
  double min_inliers = 0.3;

  void describe(ParamVisitor& v) {
    v.field("enabled", enabled, "Measure the motion between keyframes by their scans where the odometry is poor.");
    v.field("min_sigma", min_sigma, "rad", {0, 1},
            "Poor means: the standard deviation of the rotation between keyframes, tilt included, is at least this; of wheels it is always.");
    v.field("leaf", leaf, "m", {0.05, 2}, "One point in a voxel of this edge is registered.");
    v.field("min_inliers", min_inliers, "", {0, 1}, "Below this share of matched points the odometry is believed.");
  }
};

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
  RoomParams rooms;
  CorridorParams corridors;
  SubmapParams submap;
  LoopParams loops;
  SolveParams solving;

  void describe(ParamVisitor& v) {
    v.field("topological_layer", topological_layer, "Rooms and corridors; off: the paper's \"w/o top. layer\".");
    v.group("factors", factors, "Weights and losses of the odometry's and the planes' factors.");
    v.group("association", association, "When a segment is a new view of a plane of the map.");
    v.group("semantics", semantics, "Axes of the building and classes of planes.");
    v.group("merging", merging, "Planes that turn out to be one.");
    v.group("topology", topology, "Factors of rooms and corridors.");
    v.group("rooms", rooms, "Which walls make a room.");
    v.group("corridors", corridors, "Which walls make a corridor.");
    v.group("submap", submap, "Motions between keyframes where the odometry is poor.");
    v.group("loops", loops, "Loop closure by scan matching.");
    v.group("solving", solving, "When the graph is solved, and how.");
  }
};

}  // namespace sgraph
