#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sgraph_slam/core/mapping/kept_map.hpp"
#include "sgraph_slam/core/mapping/params.hpp"
#include "sgraph_slam/core/store/map_observer.hpp"
#include "sgraph_slam/core/types/decision.hpp"
#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/scene.hpp"
#include "sgraph_slam/core/types/segments.hpp"

namespace sgraph {

/// Fourth stage: owns the S-Graph. Associates planes, finds rooms and corridors, closes loops and optimises all layers together. Single-threaded
/// inside; one caller at a time.
class BackEnd {
 public:
  /// `T_base_lidar`: pose of the LiDAR on the robot. `clouds`: where the keyframes' clouds go once mapping is done with them; null: they stay in
  /// memory.
  BackEnd(const MappingParams& params, const Pose& T_base_lidar, std::shared_ptr<KeyframeClouds> clouds = nullptr);
  ~BackEnd();

  /// Shows the map to the observer after each keyframe and each optimisation, until another is given or null. It must outlive its use.
  void observe(MapObserver* observer);

  /// Goes on with a map made earlier, in a further session; to be called before the first keyframe. `T_map_odom`: where the session's odometry lies
  /// in it, `covariance`: how sure that is for its first keyframe (right perturbation). Keyframes get ids after those of the map, and their odometry
  /// the frame of the map's.
  void go_on_with(KeptMap map, const Pose& T_map_odom, const Matrix6& covariance);

  /// Takes a keyframe and the planes seen in its cloud (same stamp), in order. Solves when the data asks for it. Returns the newest state. Throws
  /// nothing that a step throws: see failures().
  GraphSnapshotPtr process(const Keyframe& keyframe, const PlaneSegments& segments);

  /// Optimises the whole graph now and returns the result, with the factors serialised and the planes' marginal covariances.
  GraphSnapshotPtr optimize();

  /// The newest state; never null.
  [[nodiscard]] GraphSnapshotPtr snapshot() const;

  /// What has been proposed since the start (rooms, corridors, merges, loops), what became of it, and why.
  [[nodiscard]] const DecisionLog& decisions() const;

  /// Steps that failed since the start, in words. The map is then as it was before the step: the keyframe is in it without its planes, or not at all.
  [[nodiscard]] const std::vector<std::string>& failures() const;

  /// CPU time that the steps of the newest keyframe, or of optimize(), took [ms]; those that were not due are missing.
  [[nodiscard]] const std::map<std::string, double>& steps() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace sgraph
