#pragma once

#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/eval/plan.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// One side of a wall between two neighbours that abut on it, in the frame of the truth. Doors and windows don't divide it.
struct WallFace {
  std::size_t wall = 0;                               ///< index in the plan
  Eigen::Vector2d begin = Eigen::Vector2d::Zero();    ///< on the surface
  Eigen::Vector2d end = Eigen::Vector2d::Zero();      ///< on the surface
  Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  ///< into the free space, |normal| = 1
  double bottom = 0;                                  ///< z [m]
  double seen_length = 0;                             ///< of its surface that was in view [m]
  double seen_begin = 0;                              ///< first and last of it, measured from `begin` [m]
  double seen_end = 0;

  [[nodiscard]] double length() const { return (end - begin).norm(); }
  [[nodiscard]] Eigen::Vector2d direction() const { return (end - begin).normalized(); }
};

/// The faces of all opaque walls, and what of each was in view from the true path: within `range` [m], at 10 degrees or more to the surface, no other
/// wall between (furniture and people are not asked; open doors and glass let through).
std::vector<WallFace> wall_faces(const Plan& plan, const std::vector<Pose>& T_truth_base, double range = 6);

}  // namespace sgraph
