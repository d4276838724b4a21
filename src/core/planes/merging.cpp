#include "sgraph_slam/core/planes/merging.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <Eigen/Cholesky>

#include "sgraph_slam/core/graph/solver.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/planes/association.hpp"

namespace sgraph {
namespace {

constexpr int fewest_apart = 2;            // views that show two planes as two: by chance, or by something before the wall, one may
constexpr double share_apart = 1.0 / 3.0;  // of the views of both: from far away they don't tell

// Midway between the nearest regions of the two: the centre of the smaller one, moved half way to the other's.
Eigen::Vector3d common_point(const PlaneRecord& a, const PlaneRecord& b) {
  const Eigen::Vector3d ca = outline_center(a.outline);
  const Eigen::Vector3d cb = outline_center(b.outline);
  const double wa = outline_area(a.outline);
  const double wb = outline_area(b.outline);
  return wa + wb > 0 ? Eigen::Vector3d((wb * ca + wa * cb) / (wa + wb)) : Eigen::Vector3d(0.5 * (ca + cb));
}

}  // namespace

PlaneDifference plane_difference(const Plane& a, const Plane& b, const Eigen::Vector3d& point) {
  const Eigen::Matrix<double, 3, 2> basis_a = tangent_basis(a.normal);
  const Eigen::Matrix<double, 3, 2> basis_b = tangent_basis(b.normal);
  PlaneDifference difference;
  difference.residual << basis_a.transpose() * b.normal, b.distance(point) - a.distance(point);
  difference.derivative.setZero();
  // Where the planes are nearly the same, turning a by an angle is turning b back by it.
  difference.derivative.topLeftCorner<2, 2>() = -Eigen::Matrix2d::Identity();
  difference.derivative.block<2, 2>(0, 3) = basis_a.transpose() * basis_b;
  difference.derivative.block<1, 2>(2, 0) = -point.transpose() * basis_a;
  difference.derivative(2, 2) = -1;
  difference.derivative.block<1, 2>(2, 3) = point.transpose() * basis_b;
  difference.derivative(2, 5) = 1;
  return difference;
}

// Planes that may be near enough to plane a. On it they are `margin` apart at most; off it, b reaches as far as it may be off at the common point and
// its distance from there at the largest angle: metres, where one of them is long. All long ones are asked, so that this holds for the others only.
std::vector<PlaneId> within_reach(const PlaneIndex& index, const PlaneRecord& a, const MergeParams& params, double margin) {
  const double reach = a.box().diagonal().norm() + PlaneIndex::long_plane + margin;
  const double off = params.max_distance + 2 * std::sin(params.max_angle) * reach + PlaneMap::stale;
  const std::vector<PlaneId> near = index.near(a.box(), std::hypot(margin, off));
  std::vector<PlaneId> all;
  std::set_union(near.begin(), near.end(), index.long_planes().begin(), index.long_planes().end(), std::back_inserter(all));
  return all;
}

std::vector<PlanePair> merge_candidates(const Graph& graph, const PlaneMap& planes, const MergeParams& params, double margin) {
  std::vector<PlanePair> pairs;
  const double limit = std::cos(params.max_angle);
  for (const auto& [id_a, a] : planes.records()) {
    const Plane* plane_a = graph.find(id_a);
    if (!plane_a) continue;
    for (const PlaneId id_b : within_reach(planes.index(), a, params, margin)) {
      if (!(id_a < id_b)) continue;
      const PlaneRecord& b = *planes.find(id_b);
      if (a.storey != b.storey) continue;
      const Plane* plane_b = graph.find(id_b);
      if (!plane_b || plane_a->normal.dot(plane_b->normal) < limit) continue;
      const Eigen::Vector3d point = common_point(a, b);
      if (std::abs(plane_b->distance(point) - plane_a->distance(point)) > params.max_distance) continue;
      if (outline_distance(*plane_a, a.outline, b.outline) > margin) continue;
      pairs.emplace_back(id_a, id_b);
    }
  }
  return pairs;
}

std::optional<double> merge_chi_square(const Graph& graph, const PlaneMap& planes, const Marginals& marginals, PlanePair pair,
                                       const MergeParams& params) {
  const Plane* a = graph.find(pair.first);
  const Plane* b = graph.find(pair.second);
  const PlaneRecord* record_a = planes.find(pair.first);
  const PlaneRecord* record_b = planes.find(pair.second);
  const auto joint = marginals.joint({pair.first, pair.second});
  if (!a || !b || !record_a || !record_b || !joint) return std::nullopt;
  const PlaneDifference difference = plane_difference(*a, *b, common_point(*record_a, *record_b));
  const Eigen::Vector3d floor(params.sigma_angle, params.sigma_angle, params.sigma_distance);
  const Eigen::Matrix3d S = difference.derivative * *joint * difference.derivative.transpose() + Eigen::Matrix3d(floor.cwiseAbs2().asDiagonal());
  return difference.residual.dot(S.ldlt().solve(difference.residual));
}

bool seen_apart(const Graph& graph, const PlaneRecord& a, const PlaneRecord& b, double chi_square) {
  const auto measured = [&graph](const PlaneObservation& seen) -> std::optional<MeasuredPlane> {
    const Factor* factor = graph.find(seen.factor);
    const auto* view = factor ? std::get_if<PosePlane>(&factor->data) : nullptr;
    if (!view) return std::nullopt;
    return MeasuredPlane{view->measured, view->weight.information().inverse()};
  };
  int together = 0;
  int apart = 0;
  auto first = b.observations.begin();  // of the keyframe at hand: both lists are in order
  for (const PlaneObservation& one : a.observations) {
    while (first != b.observations.end() && first->keyframe < one.keyframe) ++first;
    if (first == b.observations.end()) break;
    if (first->keyframe != one.keyframe) continue;
    const auto plane_a = measured(one);
    if (!plane_a) continue;
    for (auto other = first; other != b.observations.end() && other->keyframe == one.keyframe; ++other) {
      const auto plane_b = measured(*other);
      if (plane_b) ++(are_apart(*plane_a, *plane_b, chi_square) ? apart : together);
    }
  }
  return apart >= fewest_apart && apart >= share_apart * (apart + together);
}

double mean_observation_error(const Graph& graph, const std::set<PlaneId>& planes) {
  double sum = 0;
  int freedom = 0;
  for (const PlaneId id : planes) {
    for (const FactorId factor_id : graph.factors_of(id)) {
      const FactorData& data = graph.find(factor_id)->data;
      if (!std::holds_alternative<PosePlane>(data) && !std::holds_alternative<PosePlanePoints>(data)) continue;
      sum += chi_square(graph, data);
      freedom += residual_rank(data);
    }
  }
  return freedom > 0 ? sum / freedom : 0;
}

}  // namespace sgraph
