#pragma once

#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "sgraph_slam/core/graph/marginals.hpp"
#include "sgraph_slam/core/planes/params.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"

namespace sgraph {

/// Two planes that may be one surface, the older first: it is the one to keep.
using PlanePair = std::pair<PlaneId, PlaneId>;

struct PlaneDifference {
  Eigen::Vector3d residual;                ///< [B(n_a)^T n_b; distance of b from a at the point] [rad, rad, m]
  Eigen::Matrix<double, 3, 6> derivative;  ///< by [plane a; plane b], each two angles in its tangent_basis and d
};

/// Difference of two planes at a point near both (map frame): there it is what the surfaces show, not what their angles do far away.
PlaneDifference plane_difference(const Plane& a, const Plane& b, const Eigen::Vector3d& point);

/// Pairs of planes that face the same way, lie on each other within the limits, and whose extents are at most `margin` [m] apart.
std::vector<PlanePair> merge_candidates(const Graph& graph, const PlaneMap& planes, const MergeParams& params, double margin);

/// Squared Mahalanobis distance between two planes, 3 degrees of freedom, with their joint marginal covariance and the added standard deviations.
/// Nothing when a plane is unknown.
std::optional<double> merge_chi_square(const Graph& graph, const PlaneMap& planes, const Marginals& marginals, PlanePair pair,
                                       const MergeParams& params);

/// Whether the keyframes that saw both planes saw two: no drift makes two of one wall in one keyframe. Views in the points form don't tell.
bool seen_apart(const Graph& graph, const PlaneRecord& a, const PlaneRecord& b, double chi_square);

/// Mean chi-square a degree of freedom over the views of the planes, losses not applied; for the undo's gate.
double mean_observation_error(const Graph& graph, const std::set<PlaneId>& planes);

}  // namespace sgraph
