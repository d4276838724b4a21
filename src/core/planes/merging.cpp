#include "sgraph_slam/core/planes/merging.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "sgraph_slam/core/graph/solver.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/planes/association.hpp"

namespace sgraph {
namespace {

constexpr int fewest_apart = 2;            // views that show two planes as two: by chance, or by something before the wall, one may
constexpr double share_apart = 1.0 / 3.0;  // of the views of both: from far away they don't tell

// Midway between the nearest regions of the two: the centre of the smaller one, moved half way to the other's.
Eigen::Vector3d common_point(const Eigen::Vector3d& center_a, double area_a, const Eigen::Vector3d& center_b, double area_b) {
  return area_a + area_b > 0 ? Eigen::Vector3d((area_b * center_a + area_a * center_b) / (area_a + area_b))
                             : Eigen::Vector3d(0.5 * (center_a + center_b));
}

Eigen::Vector3d common_point(const PlaneRecord& a, const PlaneRecord& b) {
  return common_point(outline_center(a.outline), outline_area(a.outline), outline_center(b.outline), outline_area(b.outline));
}

// What is asked of each plane against each other one, side by side in memory.
struct Extended {
  Plane plane;
  int storey;
  Eigen::Vector3d center;
  double area;
  Eigen::AlignedBox3d box;
  double diagonal;
  const PlaneRecord* record;
};

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

// All pairs are asked: that their normals are alike is a matter of nanoseconds, and few are. Searching for neighbours by the boxes around them took
// longer for hundreds of planes.
std::vector<PlanePair> merge_candidates(const Graph& graph, const PlaneMap& planes, const MergeParams& params, double margin) {
  std::vector<Extended> all;
  all.reserve(planes.records().size());
  for (const auto& [id, record] : planes.records()) {
    const Plane* plane = graph.find(id);
    const Eigen::AlignedBox3d box = record.box();
    if (plane != nullptr && !box.isEmpty())
      all.push_back({*plane, record.storey, outline_center(record.outline), outline_area(record.outline), box, box.diagonal().norm(), &record});
  }
  std::vector<PlanePair> pairs;
  const double limit = std::cos(params.max_angle);
  const double sine = std::sin(params.max_angle);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Extended& a = all[i];
    for (std::size_t k = i + 1; k < all.size(); ++k) {
      const Extended& b = all[k];
      if (a.plane.normal.dot(b.plane.normal) < limit || a.storey != b.storey) continue;
      const Eigen::Vector3d point = common_point(a.center, a.area, b.center, b.area);
      if (std::abs(b.plane.distance(point) - a.plane.distance(point)) > params.max_distance) continue;
      // On the plane they are `margin` apart at most; off it b reaches as far as it may be off at the common point, and its way from there at the
      // largest angle.
      const double off = params.max_distance + 2 * sine * (a.diagonal + b.diagonal + margin) + PlaneMap::stale;
      if (a.box.squaredExteriorDistance(b.box) > margin * margin + off * off) continue;
      if (outline_distance(a.plane, a.record->outline, b.record->outline) <= margin) pairs.emplace_back(a.record->id, b.record->id);
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
