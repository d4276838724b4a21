#pragma once

#include <Eigen/Core>

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/types/ids.hpp"

namespace sgraph {

/// The two faces of one wall: planes with opposed normals, a thickness apart.
///
///   e = ( -(n_a . p + d_a) - (n_b . p + d_b) - thickness ) / sigma,  1 residual [m]
///
/// p: a point at the wall, map frame, a constant. Where the faces are exactly opposed it drops out and `d_a + d_b = -thickness` is left; otherwise it
/// says where the thickness is measured (at the map's origin, half a degree between the faces of a wall 50 m away would be 0.4 m). Blocks: plane a,
/// plane b. Holds no angle: use it with ParallelPlanes. Source: design: Rooms and corridors, informative mechanism 4.
struct WallThickness {
  PlaneId a;
  PlaneId b;
  double thickness = 0;                             ///< [m]
  double sigma = 0.02;                              ///< standard deviation [m]
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< map frame [m]

  static constexpr const char* type = "wall_thickness";
  static constexpr int residuals = 1;
  static constexpr int rank = 1;

  template <class Self, class Visitor>
  static void describe(Self& f, Visitor& v) {
    v.blocks("planes", f.a, f.b);
    v.sigma("sigma", f.sigma);
    v.field("thickness", f.thickness);
    v.field("point", f.point);
  }
};

CostPtr make_cost(const WallThickness& factor);

}  // namespace sgraph
