#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/graph/graph.hpp"
#include "sgraph_slam/core/places/find_places.hpp"
#include "sgraph_slam/core/places/topology.hpp"
#include "sgraph_slam/core/planes/merging.hpp"
#include "sgraph_slam/core/planes/params.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"
#include "sgraph_slam/core/types/decision.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// A place and since when it is known.
struct PlaceRecord {
  FoundPlace place;
  KeyframeId since;
  int storey = 0;
};

struct DoorRecord {
  FoundDoor door;
  std::string from;  ///< "room/3", "corridor/0"
  std::string to;    ///< empty: where the robot has not been
  int storey = 0;
};

/// Corridors that are one piece of floor, or one whose floor is no rectangle.
struct BranchingRecord {
  PlaceOutline outline;
  std::vector<CorridorId> parts;  ///< in order
  int storey = 0;
};

/// Floor and ceiling of a storey in the map.
struct StoreyHeights {
  double floor = 0;    ///< [m]
  double ceiling = 0;  ///< [m]
  bool ceiling_seen = false;
};

/// The largest horizontal planes of a storey below and above its keyframes; without a floor, the lowest point of the walls.
StoreyHeights find_storey(const Graph& graph, const PlaneMap& planes, const std::map<KeyframeId, Pose>& keyframes, int number);
/// Of a map that has one storey.
StoreyHeights find_storey(const Graph& graph, const PlaneMap& planes);

/// What the layer looks at: one storey.
struct Survey {
  const std::vector<Wall>& walls;
  const std::vector<Eigen::Vector2d>& path;  ///< of the base, every scan, map frame
  StoreyHeights storey;
  double building_yaw = 0;
  KeyframeId now;
  bool measure_all_doors = false;                                      ///< the known ones too
  int number = 0;                                                      ///< of the storey
  std::optional<std::map<KeyframeId, Pose>> keyframes = std::nullopt;  ///< on it; none given: all
};

/// What the layer is told of: its own parameters, and when two planes may be one wall.
struct PlaceLayerParams {
  TopologyParams topology;
  PlaceParams places;
  FreeSpaceParams free_space;
  MergeParams merging;
};

/// The places of the map and the doors between them. Finds them on walls and free space, as a whole each time, so that they don't depend on where the
/// robot began; knows them again, so that they keep their ids while they grow, split and join. Decides on shapes only; estimates are the graph's.
class TopologicalLayer {
 public:
  explicit TopologicalLayer(const PlaceLayerParams& params) : params_(params) {}

  /// Takes the rays of a keyframe's cloud, which was taken on a storey.
  void add(KeyframeId id, const Cloud& cloud, const Pose& T_base_lidar, int storey = 0) { space_of(storey).add(id, cloud, T_base_lidar); }

  /// Marks what a few keyframes of a storey saw on its free space ahead of the next find() (see FreeSpace::mark_ahead).
  void mark_ahead(int storey, const std::function<const Pose*(KeyframeId)>& pose_of, int most) { space_of(storey).mark_ahead(pose_of, most); }

  /// Planes seen lately that lie along the sides of the place around a position, and the planes that these sides have: they may be one wall.
  [[nodiscard]] std::vector<PlanePair> shown_at(const std::vector<Wall>& walls, const Eigen::Vector2d& position, KeyframeId now,
                                                int storey = 0) const;

  /// Finds all places as walls and poses are now. `graph` gives poses and fresh ids.
  void find(Graph& graph, const Survey& survey, DecisionLog& log) { find(graph, std::vector<Survey>{survey}, log); }
  /// Of several storeys, at least one.
  void find(Graph& graph, const std::vector<Survey>& surveys, DecisionLog& log);

  /// Whether all planes that bound its places are still in the graph, merged ones counted as what they were merged into.
  [[nodiscard]] bool is_bounded_by(const Graph& graph) const;

  /// Room, hall or corridor at a position.
  [[nodiscard]] bool covers(const Eigen::Vector2d& position) const;
  /// Rooms and halls.
  [[nodiscard]] const std::map<RoomId, PlaceRecord>& rooms() const { return rooms_; }
  [[nodiscard]] const std::map<CorridorId, PlaceRecord>& corridors() const { return corridors_; }
  [[nodiscard]] const std::map<DoorId, DoorRecord>& doors() const { return doors_; }
  [[nodiscard]] const std::vector<BranchingRecord>& branchings() const { return branchings_; }
  /// The storeys looked at last, by number.
  [[nodiscard]] const std::map<int, StoreyHeights>& storeys() const { return storeys_; }
  /// Rooms, then corridors, by id.
  [[nodiscard]] std::vector<Place> places(int storey = 0) const;

 private:
  // A place under its name, while names are given anew.
  struct Known {
    bool corridor = false;
    std::int64_t id = -1;
    PlaceRecord record;
    bool lost = false;  // not found the last times
  };
  static std::string name_of(const Known& known);
  std::vector<std::string> give_names(Graph& graph, std::vector<FoundPlace> found, const std::vector<int>& storeys, KeyframeId now, DecisionLog& log);
  void give_names_to_doors(const std::vector<FoundDoor>& found, const std::vector<std::string>& names, const std::vector<int>& storeys,
                           bool measure_all, KeyframeId now, DecisionLog& log);
  void keep_branchings(const std::vector<FoundBranching>& found, const std::vector<std::string>& names, const std::vector<int>& storeys,
                       KeyframeId now, DecisionLog& log);
  void take(FoundPlaces found, FoundPlaces& all) const;
  FreeSpace& space_of(int storey) { return spaces_.emplace(storey, params_.free_space).first->second; }

  PlaceLayerParams params_;
  std::map<int, FreeSpace> spaces_;
  std::map<int, StoreyHeights> storeys_;
  std::map<RoomId, PlaceRecord> rooms_;
  std::map<CorridorId, PlaceRecord> corridors_;
  std::vector<Known> lost_;                  // they keep their names for when they are found again
  std::vector<BranchingRecord> branchings_;  // by their first parts
  std::map<DoorId, DoorRecord> doors_;
  std::int64_t next_door_ = 0;
};

/// The edit that makes the graph's rooms, corridors and the factors of their walls those of the layer. `z`: height of each place's centre in the map.
struct PlaceHeights {
  std::map<RoomId, double> rooms;
  std::map<CorridorId, double> corridors;
};
Transaction synchronise_topology(const Graph& graph, const TopologicalLayer& layer, const PlaneMap& planes, const PlaceHeights& heights,
                                 const TopologyParams& params);

}  // namespace sgraph
