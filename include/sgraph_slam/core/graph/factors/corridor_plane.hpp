#pragma once

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/graph/variables.hpp"

namespace sgraph {

/// Which wall of a corridor, looking along its direction. In the order of SceneCorridor::planes.
enum class CorridorSide { right, left };

const char* to_string(CorridorSide value);

/// A wall of a corridor.
///
///   e = ( n . c + d - w / 2 ) / sigma,  1 residual [m]: how much further than half the width the centre is from the wall
///   c = centre of the corridor in the map, from position, yaw, along and z
///
/// Blocks: corridor, plane. Exactly parallel walls give the paper's `(kappa - w/2) - s` at the right (n across to the left, s = -d) and its negative
/// at the left (s = +d); see RoomPlane for why it is measured at the centre. The side is in the sign of the normal; it is kept for readers of the
/// graph. The two factors of a corridor determine its two states and tell planes and poses nothing. Degenerate for a wall across the corridor.
/// Source: paper, Topological Layer; design: Rooms and corridors.
struct CorridorPlane {
  CorridorId corridor;
  PlaneId plane;
  CorridorSide side = CorridorSide::right;
  double sigma = 0.02;  ///< standard deviation [m]

  static constexpr const char* type = "corridor_plane";
  static constexpr int residuals = 1;
  static constexpr int rank = 1;
  [[nodiscard]] CorridorId constants_of() const { return corridor; }

  template <class Self, class Visitor>
  static void describe(Self& f, Visitor& v) {
    v.block("corridor", f.corridor);
    v.block("plane", f.plane);
    v.choice("side", f.side, {CorridorSide::right, CorridorSide::left});
    v.sigma("sigma", f.sigma);
  }
};

/// `corridor`: for its constants.
CostPtr make_cost(const CorridorPlane& factor, const Corridor& corridor);

}  // namespace sgraph
