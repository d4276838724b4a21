#pragma once

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/graph/sqrt_information.hpp"
#include "sgraph_slam/core/types/ids.hpp"
#include "sgraph_slam/core/types/plane.hpp"

namespace sgraph {

/// Knowledge of a plane in the map (from a saved map, a level floor).
///
///   e = W [ B(n_prior)^T n ; d - d_prior ],  3 residuals [rad, rad, m], map frame; B = tangent_basis
///
/// Block: plane. Degenerate like the observation when the normals are 90 degrees apart. Source: design: Planes.
struct PlanePrior {
  PlaneId plane;
  Plane prior;                ///< map frame
  SqrtInformation<3> weight;  ///< of [two angles in tangent_basis(prior.normal); d]

  static constexpr const char* type = "plane_prior";
  static constexpr int residuals = 3;
  static constexpr int rank = 3;

  template <class Self, class Visitor>
  static void describe(Self& f, Visitor& v) {
    v.block("plane", f.plane);
    v.field("prior", f.prior);
    v.field("sqrt_information", f.weight);
  }
};

CostPtr make_cost(const PlanePrior& factor);

}  // namespace sgraph
