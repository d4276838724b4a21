#include "sgraph_slam/core/planes/association.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {

Innovation plane_innovation(const Plane& plane_map, const Pose& T_map_base, const Pose& T_base_lidar, const Plane& measured) {
  const Pose T_map_lidar = T_map_base * T_base_lidar;
  const Plane predicted = T_map_lidar.inverse() * plane_map;
  const Eigen::Matrix<double, 3, 2> measured_basis = tangent_basis(measured.normal);
  const Eigen::Matrix<double, 3, 2> map_basis = tangent_basis(plane_map.normal);
  const Eigen::Vector3d n_base = T_map_base.rotation.conjugate() * plane_map.normal;

  Innovation innovation;
  innovation.residual << measured_basis.transpose() * predicted.normal, predicted.d - measured.d;
  // n_L = R_BL^T exp(-phi) n_B and d_L = d_M + n_M . t_ML
  innovation.d_keyframe.setZero();
  innovation.d_keyframe.topLeftCorner<2, 3>() = measured_basis.transpose() * T_base_lidar.matrix().transpose() * skew(n_base);
  innovation.d_keyframe.bottomLeftCorner<1, 3>() = T_base_lidar.translation.cross(n_base).transpose();
  innovation.d_keyframe.bottomRightCorner<1, 3>() = n_base.transpose();
  innovation.d_plane.setZero();
  innovation.d_plane.topLeftCorner<2, 2>() = measured_basis.transpose() * T_map_lidar.matrix().transpose() * map_basis;
  innovation.d_plane.bottomLeftCorner<1, 2>() = T_map_lidar.translation.transpose() * map_basis;
  innovation.d_plane(2, 2) = 1;
  return innovation;
}

Eigen::Matrix3d floored_covariance(const PlaneSegment& segment, double sigma_angle, double sigma_distance) {
  // Distance at the centroid c: delta = c . B a + d, so d = delta - c . B a.
  Eigen::Matrix3d from_centroid = Eigen::Matrix3d::Identity();
  from_centroid.bottomLeftCorner<1, 2>() = -segment.centroid.transpose() * tangent_basis(segment.plane.normal);
  const Eigen::Vector3d variance(sigma_angle * sigma_angle, sigma_angle * sigma_angle, sigma_distance * sigma_distance);
  return segment.covariance + from_centroid * variance.asDiagonal() * from_centroid.transpose();
}

const char* to_string(MatchVerdict value) {
  switch (value) {
    case MatchVerdict::accepted: return "accepted";
    case MatchVerdict::facing: return "facing another way";
    case MatchVerdict::distant: return "not on the plane";
    case MatchVerdict::apart: return "not where the plane has been seen";
    case MatchVerdict::chi_square: break;
  }
  return "beyond the chi-square gate";
}

MatchVerdict gate(const PlaneSegment& segment, const Outline& segment_map, const Pose& T_map_base, const Pose& T_base_lidar,
                  const PlaneCandidate& candidate, const PredictedCovariance& predicted, const AssociationParams& params, Match* match) {
  const Pose T_map_lidar = T_map_base * T_base_lidar;
  const Eigen::Vector3d normal_map = T_map_lidar.rotation * segment.plane.normal;
  if (normal_map.dot(candidate.plane.normal) < std::cos(params.max_angle)) return MatchVerdict::facing;
  if (std::abs(candidate.plane.distance(T_map_lidar * segment.centroid)) > params.max_distance) return MatchVerdict::distant;
  if (!candidate.outline || outline_distance(candidate.plane, *candidate.outline, segment_map) > params.extent_margin) return MatchVerdict::apart;
  const Innovation innovation = plane_innovation(candidate.plane, T_map_base, T_base_lidar, segment.plane);
  const Eigen::Matrix3d S = predicted(candidate.id, innovation) + floored_covariance(segment, params.sigma_angle, params.sigma_distance);
  const Eigen::LDLT<Eigen::Matrix3d> factored(S);
  if (factored.info() != Eigen::Success || !factored.isPositive()) return MatchVerdict::chi_square;
  match->id = candidate.id;
  match->chi_square = innovation.residual.dot(factored.solve(innovation.residual));
  match->cost = match->chi_square + factored.vectorD().array().log().sum();
  return match->chi_square < params.chi_square ? MatchVerdict::accepted : MatchVerdict::chi_square;  // false for NaN
}

bool side_is_unsure(const PlaneSegment& segment, const std::vector<Eigen::Vector3d>& origins) {
  constexpr double clear = 0.1;  // a surface isn't seen from nearer to its plane than this, without another one behind it in view too [m]
  return std::any_of(origins.begin(), origins.end(), [&](const Eigen::Vector3d& origin) { return segment.plane.distance(origin) < clear; });
}

PlaneSegment flipped(const PlaneSegment& segment) {
  PlaneSegment other = segment;
  other.plane = {-segment.plane.normal, -segment.plane.d};
  // The tangent basis turns with the normal, and d changes its sign.
  Eigen::Matrix3d J = Eigen::Matrix3d::Zero();
  J.topLeftCorner<2, 2>() = -tangent_basis(other.plane.normal).transpose() * tangent_basis(segment.plane.normal);
  J(2, 2) = -1;
  other.covariance = J * segment.covariance * J.transpose();
  std::reverse(other.extent.begin(), other.extent.end());
  return other;
}

bool are_apart(const MeasuredPlane& a, const MeasuredPlane& b, double chi_square) {
  const Innovation difference = plane_innovation(b.plane, Pose{}, Pose{}, a.plane);
  const Eigen::Matrix3d S = difference.d_plane * b.covariance * difference.d_plane.transpose() + a.covariance;
  return difference.residual.dot(S.ldlt().solve(difference.residual)) > chi_square;
}

std::vector<Match> associate(const PlaneSegment& segment, const Pose& T_map_base, const Pose& T_base_lidar,
                             const std::vector<PlaneCandidate>& candidates, const PredictedCovariance& predicted, const AssociationParams& params) {
  const Pose T_map_lidar = T_map_base * T_base_lidar;
  Outline segment_map;
  for (const auto& p : segment.extent) segment_map.push_back(T_map_lidar * p);
  std::vector<Match> matches;
  for (const PlaneCandidate& candidate : candidates) {
    Match match;
    if (gate(segment, segment_map, T_map_base, T_base_lidar, candidate, predicted, params, &match) == MatchVerdict::accepted)
      matches.push_back(match);
  }
  std::sort(matches.begin(), matches.end(), [](const Match& a, const Match& b) { return a.cost < b.cost || (a.cost == b.cost && a.id < b.id); });
  return matches;
}

}  // namespace sgraph
