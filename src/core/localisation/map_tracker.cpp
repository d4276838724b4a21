#include "sgraph_slam/core/localisation/map_tracker.hpp"

#include <Eigen/LU>
#include <cmath>

#include "sgraph_slam/core/graph/solver.hpp"
#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/planes/association.hpp"

namespace sgraph {
namespace {

constexpr std::size_t window = 8;  // keyframes solved together
constexpr int iterations = 8;
constexpr double near = 30;                  // [m] planes further away than what a scan sees are not asked for
constexpr double least_sigma_angle = 0.001;  // of a pose in the map, however many planes hold it [rad]
constexpr double least_sigma = 0.004;        // [m]
constexpr std::size_t judged = 6;            // keyframes that are compared with the map
constexpr int patience = 3;                  // contradictions in a row before it is believed
constexpr double least_seen = 6;             // [m] of wall that say anything

// Ids in the small graph: 0 is the map itself.
KeyframeId node(std::size_t i) { return {static_cast<std::int64_t>(i) + 1}; }

SqrtInformation<6> weight_of(const Matrix6& covariance) { return SqrtInformation<6>::from_covariance(covariance, Vector6::Constant(1e-6)); }

Matrix6 floored(Matrix6 covariance) {
  covariance.diagonal().head<3>().array() += least_sigma_angle * least_sigma_angle;
  covariance.diagonal().tail<3>().array() += least_sigma * least_sigma;
  return covariance;
}

}  // namespace

MapTracker::MapTracker(std::shared_ptr<const ReferenceMap> map, const MapTrackerParams& params, const Pose& T_base_lidar, const Pose& T_map_odom,
                       const Matrix6& covariance)
    : map_(std::move(map)), params_(params), T_base_lidar_(T_base_lidar), T_map_odom_(T_map_odom), covariance_(covariance) {}

Matrix6 MapTracker::step_covariance(const Keyframe& keyframe) const {
  const FactorParams& params = params_.factors;
  Matrix6 covariance = keyframe.covariance;
  covariance.diagonal().head<3>().array() += params.keyframe_floor_angle * params.keyframe_floor_angle;
  covariance.diagonal().tail<3>().array() += params.keyframe_floor_distance * params.keyframe_floor_distance;
  for (const Vector6& v : keyframe.degenerate) {
    const double sigma = std::hypot(v.head<3>().norm() * params.degenerate_angle, v.tail<3>().norm() * params.degenerate_distance);
    covariance += sigma * sigma * v * v.transpose();
  }
  return covariance;
}

Pose MapTracker::process(const LocatedKeyframe& seen) {
  Pose predicted = T_map_odom_ * seen.keyframe.T_odom_base;
  Matrix6 covariance = covariance_;
  if (!recent_.empty()) {
    const Pose motion = recent_.back().seen.keyframe.T_odom_base.inverse() * seen.keyframe.T_odom_base;
    predicted = recent_.back().T_map_base * motion;
    const Matrix6 adjoint = se3_adjoint(motion.inverse());
    covariance = adjoint * covariance * adjoint.transpose() + step_covariance(seen.keyframe);
  }
  Recent now{seen, predicted, covariance, {}};
  now.seen.keyframe.cloud.reset();
  now.views = views_of(seen, predicted, &covariance);
  now.covariance = covariance_ = floored(covariance);
  recent_.push_back(std::move(now));
  if (recent_.size() > window) recent_.pop_front();
  solve_recent();
  T_map_odom_ = recent_.back().T_map_base * seen.keyframe.T_odom_base.inverse();
  judge();
  return recent_.back().T_map_base;
}

std::vector<MapTracker::View> MapTracker::views_of(const LocatedKeyframe& seen, const Pose& T_map_base, Matrix6* covariance) const {
  std::vector<PlaneCandidate> candidates;
  std::map<PlaneId, const ReferenceMap::Face*> faces;
  const Eigen::Vector3d here = T_map_base.translation;
  for (const ReferenceMap::Face& face : map_->faces()) {
    if (std::abs(face.plane.distance(here)) > near) continue;
    candidates.push_back({face.id, face.plane, &face.outline});
    faces[face.id] = &face;
  }
  const Matrix6 prior = *covariance;
  const auto predicted = [&](PlaneId id, const Innovation& innovation) -> Eigen::Matrix3d {
    return innovation.d_keyframe * prior * innovation.d_keyframe.transpose() +
           innovation.d_plane * faces.at(id)->covariance * innovation.d_plane.transpose();
  };
  std::vector<View> views;
  Matrix6 information = prior.inverse();
  for (const PlaneSegment& segment : seen.segments.segments) {
    if (!segment.plane.normal.allFinite() || !std::isfinite(segment.plane.d) || segment.extent.size() < 3 || !segment.covariance.allFinite())
      continue;
    const std::vector<Match> matches = associate(segment, T_map_base, T_base_lidar_, candidates, predicted, params_.association);
    if (matches.empty()) continue;
    const PlaneId id = matches.front().id;
    const Eigen::Matrix3d measured = floored_covariance(segment, params_.factors.plane_floor_angle, params_.factors.plane_floor_distance);
    views.push_back(
        {id, PosePlane{{}, id, segment.plane, T_base_lidar_, SqrtInformation<3>::from_covariance(measured, Eigen::Vector3d::Constant(1e-6))}});
    const Innovation innovation = plane_innovation(faces.at(id)->plane, T_map_base, T_base_lidar_, segment.plane);
    const Eigen::Matrix3d total = measured + innovation.d_plane * faces.at(id)->covariance * innovation.d_plane.transpose();
    information += innovation.d_keyframe.transpose() * total.inverse() * innovation.d_keyframe;
  }
  *covariance = information.inverse();
  return views;
}

void MapTracker::solve_recent() {
  Transaction edit;
  edit.reason = "keyframes in the map";
  edit.keyframes[{0}] = {};
  SolveScope scope;
  scope.free.emplace();
  std::map<PlaneId, Plane> planes;
  for (const ReferenceMap::Face& face : map_->faces()) planes[face.id] = face.plane;
  const RobustLoss loss{loss_kind_from(params_.factors.plane_loss), params_.factors.plane_loss_scale};
  const auto add = [&edit](const FactorData& data, const RobustLoss& with = {}) {
    Factor& factor = edit.factors.emplace_back();
    factor.data = data;
    factor.loss = with;
  };
  for (std::size_t i = 0; i < recent_.size(); ++i) {
    const Recent& recent = recent_[i];
    edit.keyframes[node(i)] = recent.T_map_base;
    scope.free->insert(node(i));
    if (i == 0) {  // what came before, as far as it is sure
      add(Se3Between{{0}, node(0), recent.T_map_base, weight_of(recent.covariance), Se3Between::Source::odometry});
    } else {
      const Pose motion = recent_[i - 1].seen.keyframe.T_odom_base.inverse() * recent.seen.keyframe.T_odom_base;
      add(Se3Between{node(i - 1), node(i), motion, weight_of(step_covariance(recent.seen.keyframe)), Se3Between::Source::odometry});
    }
    for (const View& view : recent.views) {
      edit.planes[view.plane] = planes.at(view.plane);
      PosePlane data = std::get<PosePlane>(view.data);
      data.keyframe = node(i);
      add(data, loss);
    }
  }
  Graph graph;
  if (!graph.apply(edit).ok()) return;
  SolverOptions options;
  options.max_iterations = iterations;
  solve(graph, options, scope);
  for (std::size_t i = 0; i < recent_.size(); ++i) recent_[i].T_map_base = *graph.find(node(i));
}

void MapTracker::judge() {
  std::vector<LocatedKeyframe> seen;
  for (std::size_t i = recent_.size() > judged ? recent_.size() - judged : 0; i < recent_.size(); ++i) seen.push_back(recent_[i].seen);
  const Surroundings surroundings = surroundings_of(seen, T_base_lidar_);
  const Pose T_level_level =
      Pose{map_->level(), Eigen::Vector3d::Zero()} * T_map_odom_ * Pose{surroundings.level.conjugate(), Eigen::Vector3d::Zero()};
  const Eigen::Matrix3d R = T_level_level.matrix();
  const LayoutFit fit = map_->search().fit(surroundings.layout, {T_level_level.translation.head<2>(), std::atan2(R(1, 0), R(0, 0))});
  const bool contradicted = fit.total >= least_seen && fit.contradicted > fit.matched;
  doubts_ = contradicted ? doubts_ + 1 : 0;
  lost_ = doubts_ >= patience;
}

}  // namespace sgraph
