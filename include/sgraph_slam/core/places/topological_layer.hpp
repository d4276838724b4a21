#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sgraph_slam/core/graph/graph.hpp"
#include "sgraph_slam/core/places/corridors.hpp"
#include "sgraph_slam/core/places/rooms.hpp"
#include "sgraph_slam/core/places/topology.hpp"
#include "sgraph_slam/core/planes/merging.hpp"
#include "sgraph_slam/core/planes/params.hpp"
#include "sgraph_slam/core/types/decision.hpp"

namespace sgraph {

/// What a room or corridor has gone through.
struct PlaceHistory {
  KeyframeId since;
  int failures = 0;               ///< judgements failed in a row
  std::optional<CorridorId> was;  ///< the corridor that a room grew out of
};

struct RoomRecord {
  RoomShape shape;
  PlaceHistory history;
};

struct CorridorRecord {
  CorridorShape shape;
  PlaceHistory history;
};

/// Where the robot is, among the walls known now.
struct Visit {
  KeyframeId keyframe;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< map frame
  double building_yaw = 0;
};

/// What the layer is told of: its own parameters, and when two planes may be one wall.
struct PlaceLayerParams {
  TopologyParams topology;
  RoomParams rooms;
  CorridorParams corridors;
  MergeParams merging;
};

/// The rooms and corridors of the map: finds them where the robot has been, knows them again, upgrades, withdraws. Decides on shapes only; estimates
/// are the graph's.
class TopologicalLayer {
 public:
  explicit TopologicalLayer(const PlaceLayerParams& params) : params_(params) {}

  /// Looks for a room, else a corridor, around a position. A place that is known already shows which planes are one wall: these pairs are returned
  /// for the merge's gate. `graph` gives fresh ids.
  std::vector<PlanePair> visit(Graph& graph, const std::vector<Wall>& walls, const Visit& visit, DecisionLog& log);

  /// Judges the places that have one of these walls, all when none is named; their shapes follow the walls. What fails too often is withdrawn.
  void judge(const Graph& graph, const std::vector<Wall>& walls, const std::set<PlaneId>* touched, KeyframeId now, DecisionLog& log);

  /// Room or corridor at a position.
  [[nodiscard]] bool covers(const Eigen::Vector2d& position) const;
  [[nodiscard]] const std::map<RoomId, RoomRecord>& rooms() const { return rooms_; }
  [[nodiscard]] const std::map<CorridorId, CorridorRecord>& corridors() const { return corridors_; }
  /// Rooms, then corridors, by id.
  [[nodiscard]] std::vector<Place> places() const;

 private:
  void follow_merges(const Graph& graph);
  std::vector<PlanePair> take_room(Graph& graph, const RoomShape& found, const std::vector<Wall>& walls, const Visit& visit, DecisionLog& log);
  std::vector<PlanePair> know_again(RoomId id, RoomRecord& known, const RoomShape& found, const std::vector<Wall>& walls, const Visit& visit,
                                    DecisionLog& log);
  std::vector<PlanePair> take_corridor(Graph& graph, const CorridorShape& found, const std::vector<Wall>& walls, const Visit& visit,
                                       DecisionLog& log);
  [[nodiscard]] bool same_wall(const std::vector<Wall>& walls, PlaneId a, PlaneId b, const Eigen::Vector2d& near) const;
  void judge_rooms(const std::vector<Wall>& walls, const std::set<PlaneId>* touched, KeyframeId now, DecisionLog& log);
  void judge_corridors(const std::vector<Wall>& walls, const std::set<PlaneId>* touched, KeyframeId now, DecisionLog& log);
  void refuse(const Visit& visit, const std::string& what, const std::string& reason, DecisionLog& log);

  PlaceLayerParams params_;
  std::map<RoomId, RoomRecord> rooms_;
  std::map<CorridorId, CorridorRecord> corridors_;
  std::set<std::string> refused_;  ///< what has been refused and said so
};

/// The edit that makes the graph's rooms, corridors and the factors of their walls those of the layer. `z`: height of each place's centre in the map.
struct PlaceHeights {
  std::map<RoomId, double> rooms;
  std::map<CorridorId, double> corridors;
};
Transaction synchronise_topology(const Graph& graph, const TopologicalLayer& layer, const PlaceHeights& heights, const TopologyParams& params);

}  // namespace sgraph
