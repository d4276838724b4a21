#include "sgraph_slam/core/odometry/keyframe_selector.hpp"

#include <cmath>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/util/voxel_set.hpp"

namespace sgraph {
std::optional<Keyframe> KeyframeSelector::add(const FinalScan& scan) {
  const Pose* last = !scans_.empty() ? &scans_.back().T_odom_base : previous_ ? &previous_->T_odom_base : nullptr;
  if (last != nullptr) {
    path_ += (scan.T_odom_base.translation - last->translation).norm();
    turned_ += rotation_angle(last->rotation, scan.T_odom_base.rotation);
  }
  scans_.push_back(scan);
  if (!previous_) return close();
  if (!scan.accepted) return std::nullopt;
  const double distance = (scan.T_odom_base.translation - previous_->T_odom_base.translation).norm();
  const double angle = rotation_angle(previous_->T_odom_base.rotation, scan.T_odom_base.rotation);
  const bool late = params_.time > 0 && scan.stamp - previous_->stamp >= params_.time;
  if (distance < params_.distance && angle < params_.angle && !late) return std::nullopt;
  return close();
}

std::optional<Keyframe> KeyframeSelector::finish() {
  if (scans_.empty()) return std::nullopt;
  return close();
}

Keyframe KeyframeSelector::close() {
  const FinalScan& scan = scans_.back();
  Keyframe keyframe;
  keyframe.id = {next_id_++};
  keyframe.stamp = scan.stamp;
  keyframe.T_odom_base = scan.T_odom_base;
  keyframe.cloud = merged_cloud(scan);
  for (const FinalScan& s : scans_) {
    keyframe.scans.push_back({s.stamp, s.T_odom_base});
    keyframe.degenerate.insert(keyframe.degenerate.end(), s.degenerate.begin(), s.degenerate.end());
  }
  keyframe.covariance = scan.covariance;
  if (previous_) {
    const Matrix6 move = se3_adjoint(scan.T_odom_base.inverse() * previous_->T_odom_base);
    keyframe.covariance += move * previous_->covariance * move.transpose();
  }
  keyframe.covariance.diagonal().head<3>().array() += std::pow(drift_.rotation * path_, 2) + std::pow(drift_.turning * turned_, 2);
  keyframe.covariance.diagonal().tail<3>().array() += std::pow(drift_.translation * path_, 2);
  previous_ = scan;
  previous_->cloud.reset();
  scans_.clear();
  path_ = 0;
  turned_ = 0;
  return keyframe;
}

CloudPtr KeyframeSelector::merged_cloud(const FinalScan& last) const {
  const bool only_last = params_.cloud == "scan" || scans_.size() == 1;
  if (only_last && last.accepted) return last.cloud;
  auto merged = std::make_shared<Cloud>();
  merged->stamp = last.stamp;
  merged->frame = last.cloud->frame;
  if (only_last) return merged;
  const bool thin = params_.leaf > 0;
  std::size_t count = 0;
  for (const FinalScan& scan : scans_) count += scan.cloud->size();
  VoxelSet taken(thin ? params_.leaf : 1.0, thin ? count : 0);
  const Pose T_lidar_odom = (last.T_odom_base * T_base_lidar_).inverse();
  // The newest scan first: its points are exact, and where two share a voxel the one nearer in time is kept.
  for (auto scan = scans_.rbegin(); scan != scans_.rend(); ++scan) {
    if (!scan->accepted) continue;
    const Pose motion = T_lidar_odom * (scan->T_odom_base * T_base_lidar_);
    const Eigen::Matrix3f rotation = motion.matrix().cast<float>();
    const Eigen::Vector3f translation = motion.translation.cast<float>();
    const auto time = static_cast<float>(scan->stamp - last.stamp);
    merged->viewpoints.insert(merged->viewpoints.begin(), {scan->stamp - last.stamp, motion.translation});
    for (Point point : scan->cloud->points) {
      const Eigen::Vector3f p = rotation * point.position() + translation;
      if (thin && !taken.insert(p.x(), p.y(), p.z())) continue;
      point.x = p.x();
      point.y = p.y();
      point.z = p.z();
      point.time += time;
      merged->points.push_back(point);
    }
  }
  return merged;
}

}  // namespace sgraph
