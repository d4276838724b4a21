#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/decision.hpp"
#include "sgraph_slam/core/types/ids.hpp"
#include "sgraph_slam/core/types/keyframe_clouds.hpp"
#include "sgraph_slam/core/types/keyframe_set.hpp"
#include "sgraph_slam/core/types/plane.hpp"
#include "sgraph_slam/core/types/pose.hpp"
#include "sgraph_slam/core/types/shared.hpp"
#include "sgraph_slam/core/types/storey.hpp"

namespace sgraph {

/// Robot tracking layer: a keyframe as the graph has it.
struct SceneKeyframe {
  KeyframeId id;
  Stamp stamp;
  Pose T_map_base;
  Pose T_odom_base;          ///< as the odometry gave it
  Shared<Trajectory> scans;  ///< final base poses in odom of the scans since the last keyframe
  KeyframeCloud cloud;       ///< LiDAR frame
  int storey = 0;            ///< or `stairwell`
};

/// One view of a plane from one keyframe.
struct SceneObservation {
  KeyframeId keyframe;
  std::vector<Eigen::Vector3d> extent;  ///< convex outline of what was seen, in the keyframe's base frame
};

/// Metric-semantic layer: one face of a wall, floor or ceiling.
struct ScenePlane {
  PlaneId id;
  Plane plane;  ///< map frame
  PlaneClass plane_class = PlaneClass::unclassified;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of [two tangent angles; d], marginal where the back end has it
  std::vector<Eigen::Vector3d> extent;                   ///< convex outline on the plane, map frame
  KeyframeSet keyframes;                                 ///< that saw it
  std::vector<SceneObservation> observations{};          ///< after an optimisation on demand; else empty
  int storey = 0;                                        ///< from which it was seen, or `stairwell`
};

using DoorId = Id<struct DoorKind>;

/// What a side of a place is.
struct SceneSide {
  enum class Kind { unknown, wall, door, opening };
  Kind kind = Kind::unknown;
  PlaneId plane{};  ///< of a wall
  DoorId door{};    ///< of a door that takes up most of the side
};

/// Whether all around a place something is known to end it: no side is unknown.
inline bool is_complete(const std::vector<SceneSide>& edges) {
  for (const SceneSide& side : edges) {
    if (side.kind == SceneSide::Kind::unknown) return false;
  }
  return !edges.empty();
}

/// Topological layer: a room of four walls around a free space, or a hall of another outline.
struct SceneRoom {
  RoomId id;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< map frame; z midway between floor and ceiling where they are known
  Eigen::Vector2d width = Eigen::Vector2d::Zero();   ///< along the room's own x and y [m]
  double yaw = 0;                                    ///< of the room's x axis in the map [rad]
  std::vector<PlaneId> planes;                       ///< a room's: walls at -x, +x, -y, +y; a hall's: those of its sides
  std::vector<Eigen::Vector2d> polygon{};            ///< inner outline in the map frame, counter-clockwise
  std::vector<SceneSide> edges{};                    ///< of the sides from each corner to the next
  int storey = 0;
  std::vector<std::vector<Eigen::Vector2d>> holes{};  ///< what lies within the outline and isn't the room's, clockwise

  /// Two facing pairs of walls around a rectangle; a hall has no width.
  [[nodiscard]] bool is_rectangle() const { return !width.isZero(0); }
};

/// Topological layer: two walls facing each other.
struct SceneCorridor {
  CorridorId id;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double width = 0;             ///< between the walls, across [m]
  double yaw = 0;               ///< of the direction along the corridor in the map [rad]
  double length = 0;            ///< derived from the common extent of the walls; no factor holds it [m]
  std::vector<PlaneId> planes;  ///< walls at the right and the left hand of that direction
  std::vector<Eigen::Vector2d> polygon{};
  std::vector<SceneSide> edges{};
  int storey = 0;
};

/// Topological layer: corridors that cross, fork or bend into one another. Together they are one piece of floor.
struct SceneBranching {
  std::vector<CorridorId> parts;
  std::vector<Eigen::Vector2d> polygon{};
  std::vector<SceneSide> edges{};
  int storey = 0;
  std::vector<std::vector<Eigen::Vector2d>> holes{};
};

/// Topological layer: an opening in a wall between two places.
struct SceneDoor {
  DoorId id;
  std::string from;  ///< "room/3" or "corridor/0"
  std::string to;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of its middle on the floor, map frame
  double yaw = 0;                                      ///< of the direction through it, out of `from` [rad]
  double width = 0;                                    ///< [m]
  double height = 0;                                   ///< of its lintel above the floor; 0: not seen [m]
  int storey = 0;
};

/// A floor level.
struct SceneStorey {
  int id = 0;
  double z = 0;               ///< of the floor in the map [m]
  double ceiling = 0;         ///< as high as the floor where none has been seen [m]
  bool height_known = false;  ///< whether `z` is known against the other storeys'
  double height_sigma = 0;    ///< to what, where a lift led to it and an accelerometer measured the ride [m]; 0 for others
};

/// An opening through which two places touch.
struct SceneOpening {
  std::string from;  ///< "room/3" or "corridor/0"
  std::string to;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

struct SolveSummary {
  int keyframes = 0;
  int planes = 0;
  int factors = 0;
  int iterations = 0;
  double initial_cost = 0;
  double final_cost = 0;
  double milliseconds = 0;
  bool converged = false;
};

/// The state of the whole graph at one moment; readers share it and nobody changes it.
struct GraphSnapshot {
  std::int64_t version = 0;
  std::string frame = "map";
  Pose T_map_odom;
  double dominant_yaw = 0;  ///< direction of the building's walls, modulo 90 degrees [rad]
  std::map<KeyframeId, SceneKeyframe> keyframes;
  std::map<PlaneId, ScenePlane> planes;
  std::map<RoomId, SceneRoom> rooms;
  std::map<CorridorId, SceneCorridor> corridors;
  std::vector<SceneBranching> branchings;
  std::vector<SceneOpening> openings;
  std::map<DoorId, SceneDoor> doors;
  std::vector<SceneStorey> storeys;
  std::string factors_json = "[]";  ///< serialised factors: JSON array, enough to rebuild the graph
  DecisionLog decisions;            ///< with the factors: all since the map began
  SolveSummary last_solve;
};

using GraphSnapshotPtr = std::shared_ptr<const GraphSnapshot>;

}  // namespace sgraph
