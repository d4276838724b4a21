#include "sgraph_slam/core/odometry/keyframe_selector.hpp"

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/util/voxel_set.hpp"

namespace sgraph {
namespace {

constexpr std::size_t most_parts = 64;   // clouds held one by one; a robot that walks closes a keyframe earlier
constexpr double least_leaf = 0.02;      // [m] of clouds put together before the keyframe closes, where all points are asked for
constexpr double same_viewpoint = 0.01;  // [m] between viewpoints of which one is enough
constexpr double same_direction = 0.98;  // cosine between directions of which one is enough

}  // namespace

std::optional<Keyframe> KeyframeSelector::add(const FinalScan& scan) {
  if (scan.ride && previous_) {
    // What was seen before the ride makes a keyframe of its own.
    std::optional<Keyframe> before;
    if (newest_) before = close();
    ride_ = scan.ride;
    hold(scan);
    return before;
  }
  const Pose* last = newest_ ? &newest_->T_odom_base : previous_ ? &previous_->T_odom_base : nullptr;
  if (last != nullptr) {
    path_ += (scan.T_odom_base.translation - last->translation).norm();
    turned_ += rotation_angle(last->rotation, scan.T_odom_base.rotation);
  }
  hold(scan);
  if (!previous_) return close();
  if (!scan.accepted) return std::nullopt;
  const double distance = (scan.T_odom_base.translation - previous_->T_odom_base.translation).norm();
  const double angle = rotation_angle(previous_->T_odom_base.rotation, scan.T_odom_base.rotation);
  const bool late = params_.time > 0 && scan.stamp - previous_->stamp >= params_.time;
  if (distance < params_.distance && angle < params_.angle && !late) return std::nullopt;
  return close();
}

std::optional<Keyframe> KeyframeSelector::finish() {
  if (!newest_) return std::nullopt;
  return close();
}

std::size_t KeyframeSelector::held_points() const {
  std::size_t count = newest_ ? newest_->cloud->size() : 0;
  for (const Part& part : parts_) count += part.cloud->size();
  return count;
}

void KeyframeSelector::hold(const FinalScan& scan) {
  scans_.push_back({scan.stamp, scan.T_odom_base});
  newest_ = scan;
  if (!scan.accepted) return;
  if (params_.cloud == "scan") {
    degenerate_.insert(degenerate_.end(), scan.degenerate.begin(), scan.degenerate.end());
    return;
  }
  if (parts_.size() >= most_parts) {
    // It stands, or nothing more is accepted: what there is is put together.
    const Part& frame = parts_.back();
    Part all{frame.stamp, frame.T_odom_lidar, merged(parts_, frame, std::max(least_leaf, params_.leaf))};
    parts_ = {std::move(all)};
    std::vector<Vector6> directions;
    directions.swap(degenerate_);
    hold_directions(directions);
  }
  degenerate_.insert(degenerate_.end(), scan.degenerate.begin(), scan.degenerate.end());
  parts_.push_back({scan.stamp, scan.T_odom_base * T_base_lidar_, scan.cloud});
}

void KeyframeSelector::hold_directions(const std::vector<Vector6>& directions) {
  for (const Vector6& direction : directions) {
    const auto same = [&](const Vector6& known) { return std::abs(known.dot(direction)) > same_direction; };
    if (std::none_of(degenerate_.begin(), degenerate_.end(), same)) degenerate_.push_back(direction);
  }
}

Keyframe KeyframeSelector::close() {
  FinalScan scan = *std::move(newest_);
  Keyframe keyframe;
  keyframe.id = {next_id_++};
  keyframe.stamp = scan.stamp;
  keyframe.T_odom_base = scan.T_odom_base;
  newest_ = scan;
  keyframe.cloud = keyframe_cloud();
  keyframe.scans = std::move(scans_);
  keyframe.degenerate = std::move(degenerate_);
  if (!scan.accepted) keyframe.degenerate.insert(keyframe.degenerate.end(), scan.degenerate.begin(), scan.degenerate.end());
  keyframe.covariance = scan.covariance;
  if (previous_) {
    const Matrix6 move = se3_adjoint(scan.T_odom_base.inverse() * previous_->T_odom_base);
    keyframe.covariance += move * previous_->covariance * move.transpose();
  }
  keyframe.covariance.diagonal().head<3>().array() += std::pow(drift_.rotation * path_, 2) + std::pow(drift_.turning * turned_, 2);
  keyframe.covariance.diagonal().tail<3>().array() += std::pow(drift_.translation * path_, 2);
  if (ride_) {
    const Eigen::Vector3d up = scan.T_odom_base.matrix().transpose().col(2);
    keyframe.covariance.bottomRightCorner<3, 3>() += unknown_rise.sigma * unknown_rise.sigma * up * up.transpose();
    keyframe.covariance.topLeftCorner<3, 3>() += carried_tilt * carried_tilt * (Eigen::Matrix3d::Identity() - up * up.transpose());
    keyframe.ride = ride_;
    ride_.reset();
  }
  scan.cloud.reset();
  previous_ = std::move(scan);
  newest_.reset();
  scans_.clear();
  degenerate_.clear();
  parts_.clear();
  path_ = 0;
  turned_ = 0;
  return keyframe;
}

CloudPtr KeyframeSelector::keyframe_cloud() const {
  const FinalScan& last = *newest_;
  const bool only_last = params_.cloud == "scan" || scans_.size() == 1;
  if (only_last && last.accepted) return last.cloud;
  const Part frame{last.stamp, last.T_odom_base * T_base_lidar_, last.cloud};
  return merged(parts_, frame, params_.leaf);
}

// The parts' points as seen from `frame`, one in a voxel of `leaf` [m]; 0: all.
CloudPtr KeyframeSelector::merged(const std::vector<Part>& parts, const Part& frame, double leaf) {
  auto merged = std::make_shared<Cloud>();
  merged->stamp = frame.stamp;
  merged->frame = frame.cloud->frame;
  const bool thin = leaf > 0;
  std::size_t count = 0;
  for (const Part& part : parts) count += part.cloud->size();
  VoxelSet taken(thin ? leaf : 1.0, thin ? count : 0);
  const Pose T_frame_odom = frame.T_odom_lidar.inverse();
  // The newest part first: its points are exact, and where two share a voxel the one nearer in time is kept.
  for (auto part = parts.rbegin(); part != parts.rend(); ++part) {
    const Pose motion = T_frame_odom * part->T_odom_lidar;
    const Eigen::Matrix3f rotation = motion.matrix().cast<float>();
    const Eigen::Vector3f translation = motion.translation.cast<float>();
    const double earlier = part->stamp - frame.stamp;
    for (Point point : part->cloud->points) {
      const Eigen::Vector3f p = rotation * point.position() + translation;
      if (thin && !taken.insert(p.x(), p.y(), p.z())) continue;
      point.set_position(p);
      point.time += static_cast<float>(earlier);
      merged->points.push_back(point);
    }
    if (part->cloud->viewpoints.empty()) merged->viewpoints.push_back({earlier, motion.translation});
    for (auto seen = part->cloud->viewpoints.rbegin(); seen != part->cloud->viewpoints.rend(); ++seen) {
      const Eigen::Vector3d position = motion * seen->position;
      if ((position - merged->viewpoints.back().position).norm() >= same_viewpoint) merged->viewpoints.push_back({seen->time + earlier, position});
    }
  }
  std::reverse(merged->viewpoints.begin(), merged->viewpoints.end());
  return merged;
}

}  // namespace sgraph
