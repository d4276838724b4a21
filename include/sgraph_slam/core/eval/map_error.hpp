#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/eval/plan.hpp"
#include "sgraph_slam/core/types/pose.hpp"
#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {

/// What a map point was measured against.
enum class PlanSurface { none, wall, floor, ceiling, column, furniture, ground };

const char* to_string(PlanSurface value);

struct SurfaceDistance {
  PlanSurface surface = PlanSurface::none;  ///< the nearest one; none when nothing is within reach
  double distance = 0;                      ///< to it [m], not negative
};

/// The true surfaces, indexed for nearest-distance queries: both faces, ends, door jambs, lintels and sills of the walls, panes, floors, ceilings,
/// columns, furniture.
class PlanSurfaces {
 public:
  /// Surfaces further than `reach` [m] from a point are not found.
  PlanSurfaces(const Plan& plan, double reach);

  /// Nearest surface of a point in the frame of the truth.
  [[nodiscard]] SurfaceDistance nearest(const Eigen::Vector3d& p) const;

 private:
  struct Solid {  // an upright box or cylinder
    Eigen::Vector3d center;
    Eigen::Vector3d half;
    Eigen::Vector2d axis;  // direction of the box's x
    bool round;
    PlanSurface surface;
    double lean = 0;  // of a wall, about `lean_height` [m]
    double lean_height = 0;
    double bow = 0;  // of a wall whose line begins at `from` along the axis and is `length` long
    double from = 0;
    double length = 1;
  };

  void add(const PlanWall& wall);
  void add_box(const PlanWall& wall, double begin, double end, double bottom, double top, double thickness, double height);
  void index();
  [[nodiscard]] static double distance(const Solid& solid, const Eigen::Vector3d& p);

  double reach_;
  std::vector<Solid> solids_;
  std::vector<PlanLevel> levels_;
  std::optional<double> ground_;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();  // of the grid of square cells
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::vector<int>> cells_;  // solids within reach of each cell
};

/// A map point further than this from every true surface shows something that isn't there [m].
constexpr double ghost_distance = 0.10;

/// Map points against the building (the paper's "point cloud RMSE", the other way round would count what was never seen).
struct MapError {
  Statistics structure;   ///< points nearest to a wall, floor, ceiling or column [m]: the map-to-plan error
  Statistics walls;       ///< of them, those nearest to a wall
  Statistics horizontal;  ///< of them, those nearest to a floor or ceiling
  Statistics furniture;   ///< points nearest to furniture that the truth lists; in no other figure
  double ghost_share =
      0;               ///< points more than `ghost_distance` off every surface, furniture and ground outdoors included, of those with a known height
  double p95 = 0;      ///< distance to the nearest surface that 95 % of them keep; at most the cap [m]
  int points = 0;      ///< in the map
  int beyond_cap = 0;  ///< left out: further than the cap from every surface (furniture that the truth doesn't list, people, views through windows)
  int outdoors = 0;    ///< left out: on the ground around the building
  int unknown_inside = 0;  ///< left out: off every surface, in a room or corridor of which the truth lists no furniture
  int unknown_height = 0;  ///< left out: 2 m or more above the floor where the truth tells no ceiling
};

/// `points` in the map's frame, `T_truth_map` from the trajectory's alignment, `cap` [m].
MapError map_error(const std::vector<Eigen::Vector3f>& points, const Pose& T_truth_map, const Plan& plan, double cap = 0.5);

}  // namespace sgraph
