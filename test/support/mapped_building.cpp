#include "mapped_building.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Dense>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/planes/outline.hpp"

namespace sgraph {
namespace {

constexpr double max_range = 15;
constexpr double spacing = 0.2;  // of the points along a wall [m]

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

Pose pose_on_ground(const Eigen::Vector2d& p, double yaw) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), {p.x(), p.y(), 0}};
}

Vector6 noise_vector(std::mt19937& random, double angle, double distance) {
  std::normal_distribution<double> normal;
  Vector6 xi;
  for (int i = 0; i < 6; ++i) xi[i] = normal(random) * (i < 3 ? angle : distance);
  return xi;
}

}  // namespace

PlaneSegment fit_segment(const std::vector<Eigen::Vector3d>& points, double sigma) {
  PlaneSegment segment;
  segment.count = static_cast<int>(points.size());
  for (const auto& p : points) {
    const Eigen::Vector4d h(p.x(), p.y(), p.z(), 1);
    segment.scatter += h * h.transpose();
    segment.centroid += p / static_cast<double>(points.size());
  }
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const auto& p : points) spread += (p - segment.centroid) * (p - segment.centroid).transpose();
  segment.plane.normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
  segment.plane.d = -segment.plane.normal.dot(segment.centroid);
  if (segment.plane.d < 0) segment.plane = {-segment.plane.normal, -segment.plane.d};
  const Eigen::Matrix<double, 3, 2> basis = tangent_basis(segment.plane.normal);
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double squares = 0;
  for (const auto& p : points) {
    Eigen::Vector3d row;
    row << basis.transpose() * p, 1;
    information += row * row.transpose() / (sigma * sigma);
    squares += std::pow(segment.plane.distance(p), 2);
  }
  segment.covariance = information.inverse();
  segment.sigma = std::sqrt(squares / static_cast<double>(points.size()));
  segment.extent = convex_outline(segment.plane, points);
  return segment;
}

void MappedBuilding::add_face(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const std::vector<Eigen::Vector2d>& doors) {
  const int wall = wall_of_.empty() ? 0 : wall_of_.back() + 1;
  const Eigen::Vector2d along = (b - a).normalized();
  double reached = 0;
  const auto add = [&](double from, double to) {
    if (to - from < 1e-6) return;
    faces_.push_back({a + from * along, a + to * along});
    wall_of_.push_back(wall);
  };
  for (const auto& door : doors) {
    add(reached, door.x());
    reached = door.y();
  }
  add(reached, (b - a).norm());
}

void MappedBuilding::add_room(double x0, double y0, double x1, double y1, const std::vector<std::vector<Eigen::Vector2d>>& doors) {
  const std::vector<Eigen::Vector2d> corners{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
  for (std::size_t i = 0; i < 4; ++i) add_face(corners[i], corners[(i + 1) % 4], doors[i]);
}

Pose MappedBuilding::T_base_lidar() { return {so3_exp({0.01, -0.02, 0.3}), {0.2, 0.05, sensor_height}}; }

bool MappedBuilding::visible(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  const Eigen::Vector2d ray = to - from;
  return std::none_of(faces_.begin(), faces_.end(), [&](const BuildingFace& face) {
    const Eigen::Vector2d along = face.b - face.a;
    const double parallel = cross(ray, along);
    if (std::abs(parallel) < 1e-12) return false;
    const double t = cross(face.a - from, along) / parallel;
    const double u = cross(face.a - from, ray) / parallel;
    return t > 1e-6 && t < 1 - 1e-3 && u >= 0 && u <= 1;
  });
}

void MappedBuilding::see(const Pose& T_world_base, const BuildingNoise& noise, std::mt19937& random, SeenKeyframe& seen) const {
  std::normal_distribution<double> normal(0, noise.range);
  const auto cloud = std::make_shared<Cloud>();
  const Pose T_world_lidar = T_world_base * T_base_lidar();
  const Pose T_lidar_world = T_world_lidar.inverse();
  const Eigen::Vector3d eye = T_world_lidar.translation;
  const auto add_segment = [&](const std::vector<Eigen::Vector3d>& points, int face) {
    for (const Eigen::Vector3d& p : points) cloud->points.emplace_back().set_position(p.cast<float>());
    if (points.size() < 12) return;
    seen.segments.segments.push_back(fit_segment(points, noise.range));
    seen.faces.push_back(face);
  };
  const auto measured = [&](const Eigen::Vector3d& p_world) -> Eigen::Vector3d {
    return T_lidar_world * p_world + normal(random) * (T_lidar_world * p_world).normalized();
  };
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    const Eigen::Vector2d along = faces_[i].b - faces_[i].a;
    if (cross(along, eye.head<2>() - faces_[i].a) <= 0.05 * along.norm()) continue;  // behind, or too flat
    std::vector<Eigen::Vector3d> cluster;
    const int steps = std::max(1, static_cast<int>(along.norm() / spacing));
    for (int k = 0; k <= steps; ++k) {
      const Eigen::Vector2d p = faces_[i].a + along * (k + 0.5) / (steps + 1);
      const double range = (p - eye.head<2>()).norm();
      if (range > max_range || !visible(eye.head<2>(), p)) {
        add_segment(cluster, wall_of_[i]);
        cluster.clear();
        continue;
      }
      const double reach = range * std::tan(15 * M_PI / 180);
      for (int ring = -2; ring <= 2; ++ring) cluster.push_back(measured({p.x(), p.y(), std::clamp(eye.z() + ring * reach / 2, 0.0, height)}));
    }
    add_segment(cluster, wall_of_[i]);
  }
  std::vector<Eigen::Vector3d> floor;
  std::vector<Eigen::Vector3d> ceiling;
  for (int angle = 0; angle < 360; angle += 5) {
    const Eigen::Vector2d direction(std::cos(angle * M_PI / 180), std::sin(angle * M_PI / 180));
    for (const double range : {2.5, 4.0, 7.5}) {
      const Eigen::Vector2d p = eye.head<2>() + range * direction;
      if (!visible(eye.head<2>(), p)) continue;
      if (range > 2.4) floor.push_back(measured({p.x(), p.y(), 0}));
      if (range > 7.4) ceiling.push_back(measured({p.x(), p.y(), height}));
    }
  }
  add_segment(floor, -1);
  add_segment(ceiling, -2);
  if (noise.clouds) seen.keyframe.cloud = cloud;
}

// What its rays ended on, without noise: it shows where the floor is free.
CloudPtr MappedBuilding::cloud_from(const Pose& T_world_base) const {
  const Pose T_world_lidar = T_world_base * T_base_lidar();
  const Pose T_lidar_world = T_world_lidar.inverse();
  const Eigen::Vector3d eye = T_world_lidar.translation;
  auto cloud = std::make_shared<Cloud>();
  for (int i = 0; i < 720; ++i) {
    const Eigen::Vector2d u(std::cos(i * M_PI / 360), std::sin(i * M_PI / 360));
    double range = max_range;
    for (const BuildingFace& face : faces_) {
      const Eigen::Vector2d along = face.b - face.a;
      const double parallel = cross(u, along);
      if (std::abs(parallel) < 1e-12) continue;
      const double t = cross(face.a - eye.head<2>(), along) / parallel;
      const double s = cross(face.a - eye.head<2>(), u) / parallel;
      if (t > 1e-6 && s >= 0 && s <= 1) range = std::min(range, t);
    }
    for (const double slope : {-0.15, -0.05, 0.02, 0.1}) {
      const double reached = slope < 0 ? std::min(range, eye.z() / -slope) : range;
      Point point;
      point.set_position(
          (T_lidar_world * Eigen::Vector3d(eye.x() + reached * u.x(), eye.y() + reached * u.y(), eye.z() + slope * reached)).cast<float>());
      cloud->points.push_back(point);
    }
  }
  return cloud;
}

std::vector<SeenKeyframe> MappedBuilding::walk(const std::vector<Eigen::Vector2d>& waypoints, double step, double start_yaw,
                                               const BuildingNoise& noise, unsigned seed) const {
  std::mt19937 random(seed);
  std::vector<SeenKeyframe> all;
  const auto stop = [&](const Eigen::Vector2d& p, double yaw) {
    SeenKeyframe seen;
    seen.T_world_base = pose_on_ground(p, yaw) * se3_exp(noise_vector(random, 0.01, 0.005));
    seen.keyframe.id = {static_cast<std::int64_t>(all.size())};
    seen.keyframe.stamp = Stamp::from_seconds(static_cast<double>(all.size()));
    seen.keyframe.cloud = cloud_from(seen.T_world_base);
    seen.segments.stamp = seen.keyframe.stamp;
    if (all.empty()) {
      seen.keyframe.T_odom_base = pose_on_ground({0, 0}, yaw + start_yaw);
    } else {
      const Pose motion = all.back().T_world_base.inverse() * seen.T_world_base;
      Pose wrong = motion * se3_exp(noise_vector(random, noise.odometry_angle, noise.odometry_distance));
      wrong.translation *= 1 + noise.odometry_scale;
      wrong = wrong * se3_exp((Vector6() << 0, 0, noise.odometry_heading * motion.translation.norm(), 0, 0, 0).finished());
      seen.keyframe.T_odom_base = all.back().keyframe.T_odom_base * wrong;
      Vector6 sigma;
      const double angle = noise.odometry_angle + noise.odometry_heading * motion.translation.norm();
      const double distance = noise.odometry_distance + noise.odometry_scale * motion.translation.norm();
      sigma << Eigen::Vector3d::Constant(angle), Eigen::Vector3d::Constant(distance);
      seen.keyframe.covariance = sigma.cwiseAbs2().asDiagonal();
    }
    seen.keyframe.scans.push_back({seen.keyframe.stamp, seen.keyframe.T_odom_base});
    see(seen.T_world_base, noise, random, seen);
    all.push_back(std::move(seen));
  };
  for (std::size_t i = 0; i + 1 < waypoints.size(); ++i) {
    const Eigen::Vector2d way = waypoints[i + 1] - waypoints[i];
    const double yaw = std::atan2(way.y(), way.x());
    const int steps = std::max(1, static_cast<int>(std::ceil(way.norm() / step)));
    for (int k = 0; k < steps; ++k) stop(waypoints[i] + way * k / steps, yaw);
    if (i + 2 == waypoints.size()) stop(waypoints[i + 1], yaw);
  }
  return all;
}

}  // namespace sgraph
