#include "sgraph_slam/core/odometry/keyframe_registration.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "sgraph_slam/core/math/noise.hpp"
#include "sgraph_slam/core/registration/rigid_alignment.hpp"
#include "sgraph_slam/core/util/voxel_set.hpp"

namespace sgraph {
namespace {

constexpr double measured_angle = 0.002;    // standard deviation of a measured motion [rad]
constexpr double measured_distance = 0.01;  // [m]
constexpr double map_leaf = 0.1;            // of what enters the map [m]

// The points of the newest scan in a keyframe's cloud: what was put together with a poor odometry is smeared, one scan isn't.
std::vector<Eigen::Vector3d> newest_points(const Cloud& cloud, double leaf) {
  const auto& scans = cloud.viewpoints;
  const double period = scans.size() < 2 ? HUGE_VAL : scans.back().time - scans[scans.size() - 2].time;
  VoxelSet taken(leaf, cloud.size());
  std::vector<Eigen::Vector3d> points;
  for (const Point& point : cloud.points) {
    if (std::abs(point.time) > period || !point.position().allFinite() || !taken.insert(point.x, point.y, point.z)) continue;
    points.emplace_back(point.position().cast<double>());
  }
  return points;
}

// The alignment's directions are about the sensor in the map's axes; these are about the base in its own.
Vector6 turned(const Eigen::Matrix3d& R, const Vector6& v) {
  Vector6 result;
  result << R * v.head<3>(), R * v.tail<3>();
  return result;
}

double rotation_sigma(const Matrix6& covariance) { return std::sqrt(covariance.diagonal().head<3>().maxCoeff()); }

}  // namespace

std::optional<KeyframeMotion> KeyframeRegistration::measure(const Keyframe& keyframe) {
  const KeyframeMotion claimed{T_odom_last_ ? T_odom_last_->inverse() * keyframe.T_odom_base : Pose{}, keyframe.covariance};
  T_odom_last_ = keyframe.T_odom_base;
  if (!params_.enabled || !keyframe.cloud || rotation_sigma(claimed.covariance) < params_.min_sigma) {
    map_.reset();
    return {};
  }
  std::optional<KeyframeMotion> measured;
  if (map_) measured = align(*keyframe.cloud, claimed);
  if (!measured) {  // it begins, or is elsewhere
    map_.emplace(SurfaceMapParams{});
    T_map_base_ = {};
  }
  insert(*keyframe.cloud);
  return measured;
}

std::optional<KeyframeMotion> KeyframeRegistration::align(const Cloud& cloud, const KeyframeMotion& claimed) {
  const Pose predicted = T_map_base_ * claimed.T_last_now;
  const Pose T_map_lidar = predicted * T_base_lidar_;
  std::vector<SeenPoint> seen;
  for (const Eigen::Vector3d& p : newest_points(cloud, params_.leaf)) seen.push_back({T_map_lidar * p, T_map_lidar.translation});
  RigidAlignmentOptions options;
  options.iterations = 10;
  options.noise = std::max(noise::mapped_surface, map_->noise());
  options.kernel_end = std::max(0.1, 4 * options.noise);
  const RigidAlignmentResult match = align_rigidly(*map_, seen, options);
  if (match.inlier_share < params_.min_inliers) return {};
  const Pose T_map_now = match.correction * predicted;
  KeyframeMotion measured{T_map_base_.inverse() * T_map_now, Matrix6::Zero()};
  measured.covariance.diagonal() << Eigen::Vector3d::Constant(measured_angle * measured_angle),
      Eigen::Vector3d::Constant(measured_distance * measured_distance);
  const Eigen::Matrix3d to_base = T_map_now.matrix().transpose();
  for (const Vector6& direction : match.free_directions) {
    const Vector6 v = turned(to_base, direction);
    measured.covariance += v.dot(claimed.covariance * v) * v * v.transpose();
  }
  T_map_base_ = T_map_now;
  return measured;
}

void KeyframeRegistration::insert(const Cloud& cloud) {
  const Pose T_map_lidar = T_map_base_ * T_base_lidar_;
  for (const Eigen::Vector3d& p : newest_points(cloud, map_leaf)) map_->insert(T_map_lidar * p, T_map_lidar.translation);
  map_->update();
}

}  // namespace sgraph
