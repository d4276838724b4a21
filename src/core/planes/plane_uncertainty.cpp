#include "sgraph_slam/core/planes/plane_uncertainty.hpp"

#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph {
namespace {
constexpr int cache_age = 10;            // keyframes; the odometry bridges them
constexpr double small_angle = 0.008;    // a bound below these two needs no marginals [rad]
constexpr double small_distance = 0.03;  // [m]
}  // namespace

PlaneUncertainty::PlaneUncertainty(const Graph& graph, const PlaneMap& planes, const OdometryDrift& drift, MarginalsCache& cache, KeyframeId now)
    : graph_(graph), planes_(planes), drift_(drift), cache_(cache), now_(now) {}

Eigen::Matrix3d PlaneUncertainty::by_odometry(const PlaneRecord& record, const Innovation& innovation) const {
  return innovation.d_plane * record.last_covariance * innovation.d_plane.transpose() +
         innovation.d_keyframe * drift_.between(record.last_seen, now_) * innovation.d_keyframe.transpose();
}

Eigen::Matrix3d PlaneUncertainty::operator()(PlaneId id, const Innovation& innovation) const {
  const PlaneRecord* record = planes_.find(id);
  if (!record) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d bound = by_odometry(*record, innovation);
  if (bound(2, 2) < small_distance * small_distance && bound.topLeftCorner<2, 2>().trace() < small_angle * small_angle) return bound;
  const Marginals* marginals = cache_.get(graph_, cache_age);
  if (!marginals) return bound;
  const KeyframeId known = cache_.newest();
  const auto joint = marginals->joint({known, id});
  const Pose* T_map_known = graph_.find(known);
  const Pose* T_map_now = graph_.find(now_);
  if (!joint || !T_map_known || !T_map_now) return bound;
  Eigen::Matrix<double, 3, 9> J;
  J << innovation.d_keyframe * se3_adjoint(T_map_now->inverse() * *T_map_known), innovation.d_plane;
  return J * *joint * J.transpose() + innovation.d_keyframe * drift_.between(known, now_) * innovation.d_keyframe.transpose();
}

}  // namespace sgraph
