#pragma once

#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "sgraph_slam/core/graph/graph.hpp"
#include "sgraph_slam/core/planes/dominant_frame.hpp"
#include "sgraph_slam/core/planes/outline.hpp"
#include "sgraph_slam/core/planes/params.hpp"
#include "sgraph_slam/core/planes/plane_index.hpp"
#include "sgraph_slam/core/planes/wall.hpp"
#include "sgraph_slam/core/types/keyframe_set.hpp"

namespace sgraph {

/// One view of a plane from one keyframe.
struct PlaneObservation {
  KeyframeId keyframe;
  FactorId factor;
  Outline outline_base;  ///< in the keyframe's base frame, so that it moves with the keyframe
};

/// What mapping knows of a plane beside its estimate in the graph.
struct PlaneRecord {
  PlaneId id;
  PlaneClass plane_class = PlaneClass::unclassified;
  std::vector<PlaneObservation> observations;  ///< in order of their keyframes
  KeyframeSet keyframes;                       ///< that saw it, those that have been retired since among them
  KeyframeSet retired;                         ///< those whose views of it are kept no more
  KeyframeId last_seen;
  int storey = 0;                                             ///< from which it was seen, or `stairwell`
  Outline outline;                                            ///< all that has been seen of it, map frame
  Eigen::Matrix3d last_covariance = Eigen::Matrix3d::Zero();  ///< of the newest view given its keyframe; tangent of the plane in the map [rad, m]
  std::optional<Wall> wall;                                   ///< when it is vertical

  Plane built;         ///< the estimate when the outline was last put together anew
  double middle = 0;   ///< height at which the wall's offset holds [m]
  bool grown = false;  ///< since then

  using Views = std::vector<PlaneObservation>::const_iterator;
  /// Those from one keyframe, first and end.
  [[nodiscard]] std::pair<Views, Views> views_of(KeyframeId keyframe) const;
  /// Around the outline; empty without one.
  [[nodiscard]] Eigen::AlignedBox3d box() const;
};

/// The records of the graph's planes: extents, classes, views. Holds no estimate.
class PlaneMap {
 public:
  explicit PlaneMap(const SemanticsParams& params) : params_(params) {}

  /// Notes a view of a plane that is in the graph; a first view makes the record. `outline_lidar`, `covariance` (tangent of the plane in the LiDAR's
  /// frame): as the segment gives them.
  void observe(const Graph& graph, PlaneId id, KeyframeId keyframe, FactorId factor, const Outline& outline_lidar, const Pose& T_base_lidar,
               const Plane& measured, const Eigen::Matrix3d& covariance);

  /// How far a plane may be off its outline, and an outline off where its keyframes have it now, until it is put together anew [m]; far below what
  /// the points of a surface scatter and what lies between them.
  static constexpr double tolerance = 0.005;
  /// Bound on how far outlines are off their planes' newest estimates between global solves, for searches by the boxes around them [m].
  static constexpr double stale = 0.5;

  /// Brings extents, walls and classes up to the graph's estimates. What hasn't moved by more than the tolerance since it was put together, and has
  /// not been seen since, keeps its extent; walls always follow their planes.
  void refresh(const Graph& graph, const DominantFrame& frame);
  /// Class of one plane, after a view.
  void reclassify(const Graph& graph, PlaneId id, const DominantFrame& frame);

  void merge(const Graph& graph, PlaneId kept, PlaneId merged);
  void erase(PlaneId id);
  void set_storey(PlaneId id, int storey);
  /// Forgets the views of a keyframe that is retired, but for those that another keyframe has from now on: old factor to new one. Extents follow when
  /// they are brought up to date.
  void retire(const Graph& graph, KeyframeId id, KeyframeId to, const std::map<FactorId, FactorId>& moved);
  void undo_merge(const Graph& graph, PlaneId kept, PlaneId merged);

  /// Takes up the records of a map made earlier: class, observations and last_covariance of each plane, and of those merged away. The rest follows.
  void restore(const Graph& graph, std::map<PlaneId, PlaneRecord> records, std::map<PlaneId, PlaneRecord> retired);

  [[nodiscard]] const std::map<PlaneId, PlaneRecord>& records() const { return records_; }
  [[nodiscard]] const PlaneRecord* find(PlaneId id) const;
  /// Where the planes are.
  [[nodiscard]] const PlaneIndex& index() const { return index_; }
  /// The walls that at least this many keyframes have seen and that are at least this high [m], by id; of one storey when it is given.
  [[nodiscard]] std::vector<Wall> walls(std::size_t min_views = 1, double min_height = 0, std::optional<int> storey = std::nullopt) const;

 private:
  void rebuild(const Graph& graph, PlaneRecord& record);
  bool follow(const Plane& plane, PlaneRecord& record) const;
  std::vector<KeyframeId> moved_keyframes(const Graph& graph);

  SemanticsParams params_;
  std::map<PlaneId, PlaneRecord> records_;
  std::map<PlaneId, PlaneRecord> retired_;  ///< by the plane merged away, as it was
  std::map<KeyframeId, Pose> poses_;        ///< of the keyframes, as the outlines have them to within the tolerance
  PlaneIndex index_;
};

/// Directions and lengths of the walls, for the dominant frame.
std::vector<WallDirection> wall_directions(const PlaneMap& planes);

}  // namespace sgraph
