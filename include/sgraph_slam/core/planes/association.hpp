#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "sgraph_slam/core/planes/outline.hpp"
#include "sgraph_slam/core/planes/params.hpp"
#include "sgraph_slam/core/types/ids.hpp"
#include "sgraph_slam/core/types/segments.hpp"

namespace sgraph {

/// A plane of the map that a segment may be a new view of.
struct PlaneCandidate {
  PlaneId id;
  Plane plane;                       ///< map frame
  const Outline* outline = nullptr;  ///< map frame
};

/// What the map says a segment should look like, beside what it looks like.
struct Innovation {
  Eigen::Vector3d residual;                ///< [B(n_hat)^T n_pred; d_pred - d_hat], LiDAR frame [rad, rad, m]
  Eigen::Matrix<double, 3, 6> d_keyframe;  ///< derivative by the keyframe's pose (rotation, translation; right perturbation, base frame)
  Eigen::Matrix3d d_plane;                 ///< derivative by the plane (two angles in tangent_basis(normal), d; map frame)
};

/// Residual of the tangent form and its derivatives (design: Planes).
Innovation plane_innovation(const Plane& plane_map, const Pose& T_map_base, const Pose& T_base_lidar, const Plane& measured);

/// Covariance of a segment's plane with standard deviations added that hold at its centroid: what all of its points share. [rad, m]
Eigen::Matrix3d floored_covariance(const PlaneSegment& segment, double sigma_angle, double sigma_distance);

/// Uncertainty of the residual that comes from the map and the pose, `J Sigma J^T`. First argument: which plane.
using PredictedCovariance = std::function<Eigen::Matrix3d(PlaneId, const Innovation&)>;

/// The first test that a candidate fails.
enum class MatchVerdict {
  accepted,
  facing,      ///< seen from its other side, or turned away by more than the gate
  distant,     ///< not on the plane
  apart,       ///< on the plane, but not where it has been seen
  chi_square,  ///< further off than the uncertainties allow
};

const char* to_string(MatchVerdict value);

struct Match {
  PlaneId id;
  double chi_square = 0;  ///< 3 degrees of freedom
  double cost = 0;        ///< chi_square + log det S: minus twice the log-likelihood, but for a constant
};

/// Gates a candidate. `segment_map`: the segment's outline moved to the map. Fills `match` when the candidate passes.
MatchVerdict gate(const PlaneSegment& segment, const Outline& segment_map, const Pose& T_map_base, const Pose& T_base_lidar,
                  const PlaneCandidate& candidate, const PredictedCovariance& predicted, const AssociationParams& params, Match* match);

/// Whether a keyframe's scans were taken from both sides of a segment's plane, or nearly in it: then the side that its normal tells is a guess.
/// `origins`: where the LiDAR was, in the segment's frame.
bool side_is_unsure(const PlaneSegment& segment, const std::vector<Eigen::Vector3d>& origins);

/// The same surface, taken to be seen from its other side.
PlaneSegment flipped(const PlaneSegment& segment);

/// A plane as a keyframe measured it, LiDAR frame, with its covariance in the tangent [rad, rad, m].
struct MeasuredPlane {
  Plane plane;
  Eigen::Matrix3d covariance;
};

/// Whether two planes that one keyframe measured can't be one: a step in a wall, a shelf beside it. Their common pose cancels, so this is sharper
/// than the gate of each with a plane of the map, which may lie aslant between the two. `chi_square`: 3 degrees of freedom.
bool are_apart(const MeasuredPlane& a, const MeasuredPlane& b, double chi_square);

/// All candidates that pass, the likeliest first; equal ones by id (paper, Metric-Semantic Layer; design: Planes, data association).
std::vector<Match> associate(const PlaneSegment& segment, const Pose& T_map_base, const Pose& T_base_lidar,
                             const std::vector<PlaneCandidate>& candidates, const PredictedCovariance& predicted, const AssociationParams& params);

}  // namespace sgraph
