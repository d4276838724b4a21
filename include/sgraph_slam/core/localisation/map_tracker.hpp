#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "sgraph_slam/core/graph/factor.hpp"
#include "sgraph_slam/core/localisation/reference_map.hpp"
#include "sgraph_slam/core/planes/params.hpp"

namespace sgraph {

struct MapTrackerParams {
  FactorParams factors;
  AssociationParams association;
};

/// Follows a robot in a map that does not change: each keyframe's planes are matched with the map's, and the last few keyframes are solved together
/// with the odometry between them. Costs the same however long it runs and however large the map is around it.
class MapTracker {
 public:
  /// `T_map_odom`: where the search found the odometry's frame, as surely as `covariance` says (of the base, right perturbation).
  MapTracker(std::shared_ptr<const ReferenceMap> map, const MapTrackerParams& params, const Pose& T_base_lidar, const Pose& T_map_odom,
             const Matrix6& covariance);

  /// Takes the next keyframe, in order. Returns its pose in the map.
  Pose process(const LocatedKeyframe& seen);

  [[nodiscard]] const Pose& T_map_odom() const { return T_map_odom_; }
  /// Whether what the last keyframes saw contradicts the map where the robot is taken to be.
  [[nodiscard]] bool is_lost() const { return lost_; }
  /// Planes of the newest keyframe that were found in the map.
  [[nodiscard]] std::size_t matched() const { return recent_.empty() ? 0 : recent_.back().views.size(); }

 private:
  struct View {
    PlaneId plane;
    FactorData data;
  };
  struct Recent {
    LocatedKeyframe seen;
    Pose T_map_base;
    Matrix6 covariance;  // as known when it was the newest
    std::vector<View> views;
  };

  std::vector<View> views_of(const LocatedKeyframe& seen, const Pose& T_map_base, Matrix6* covariance) const;
  void solve_recent();
  [[nodiscard]] Matrix6 step_covariance(const Keyframe& keyframe) const;
  void judge();

  std::shared_ptr<const ReferenceMap> map_;
  MapTrackerParams params_;
  Pose T_base_lidar_;
  Pose T_map_odom_;
  Matrix6 covariance_;
  std::deque<Recent> recent_;
  int doubts_ = 0;  // keyframes in a row that contradict the map
  bool lost_ = false;
};

}  // namespace sgraph
