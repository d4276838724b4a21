#pragma once

#include <map>
#include <string>
#include <vector>

#include "sgraph_slam/core/graph/factor.hpp"

namespace sgraph {

/// Two planes that turned out to be one surface: every factor of `merged` is re-pointed to `kept` with its own measurement, and `merged` leaves the
/// graph.
struct PlaneMerge {
  PlaneId kept;
  PlaneId merged;
};

/// An edit of the graph, proposed by association, detectors or loop closers and applied as a whole or not at all. Steps are taken in the order of the
/// members: undo, add, remove, merge.
struct Transaction {
  std::string reason;  ///< who proposes it and why, for the log

  std::vector<PlaneId> undo_merges;  ///< planes merged earlier that shall stand on their own again
  std::map<KeyframeId, Pose> keyframes;
  std::map<PlaneId, Plane> planes;
  std::map<RoomId, Room> rooms;
  std::map<CorridorId, Corridor> corridors;
  std::vector<Factor> factors;
  std::vector<FactorId> remove_factors;
  std::vector<VariableId> remove_variables;  ///< their factors go with them
  std::vector<PlaneMerge> merges;
};

enum class Refusal {
  none,
  duplicate_id,    ///< a variable to add exists, existed, or has no valid id
  unknown_id,      ///< a variable or factor that isn't in the graph
  not_finite,      ///< NaN, infinity, a normal or quaternion not of unit length, a weight or sigma that isn't positive
  invalid_factor,  ///< a factor between a variable and itself
  opposed_planes,  ///< a merge of two faces of a wall
};

const char* to_string(Refusal value);

struct Applied {
  Refusal refusal = Refusal::none;
  std::string detail;             ///< what was refused, in words
  std::vector<FactorId> factors;  ///< ids of the factors added, in the transaction's order

  [[nodiscard]] bool ok() const { return refusal == Refusal::none; }
};

}  // namespace sgraph
