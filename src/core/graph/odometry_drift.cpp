#include "sgraph_slam/core/graph/odometry_drift.hpp"

#include <cmath>

#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph {

void OdometryDrift::add(KeyframeId id, const Pose& T_odom_base, const Matrix6& covariance) {
  Entry entry{T_odom_base, Matrix6::Zero(), 0};
  if (!entries_.empty()) {
    const Entry& last = entries_.rbegin()->second;
    const Matrix6 adjoint = se3_adjoint(T_odom_base);
    entry.sum = last.sum + adjoint * covariance * adjoint.transpose();
    entry.path = last.path + (T_odom_base.translation - last.T_odom_base.translation).norm();
  }
  entries_[id] = entry;
}

Matrix6 OdometryDrift::between(KeyframeId from, KeyframeId to) const {
  const auto a = entries_.find(from);
  const auto b = entries_.find(to);
  if (a == entries_.end() || b == entries_.end() || a == b) return Matrix6::Zero();
  const Matrix6 adjoint = se3_adjoint(b->second.T_odom_base.inverse());
  return adjoint * (b->second.sum - a->second.sum) * adjoint.transpose();
}

double OdometryDrift::path(KeyframeId from, KeyframeId to) const {
  const auto a = entries_.find(from);
  const auto b = entries_.find(to);
  return a == entries_.end() || b == entries_.end() ? 0 : std::abs(b->second.path - a->second.path);
}

}  // namespace sgraph
