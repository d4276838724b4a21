#include "sgraph_slam/core/odometry/motion.hpp"

#include <algorithm>
#include <cmath>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {

SegmentMotion::SegmentMotion(const Pose& begin, const Pose& end)
    : rotation_(begin.matrix()), begin_(begin.translation), step_(end.translation - begin.translation) {
  const Eigen::Vector3d phi = so3_log(begin.rotation.conjugate() * end.rotation);
  angle_ = phi.norm();
  const Eigen::Matrix3d w = skew(angle_ > 0 ? Eigen::Vector3d(phi / angle_) : Eigen::Vector3d::UnitZ());
  first_ = rotation_ * w;
  second_ = first_ * w;
}

Eigen::Vector3d SegmentMotion::rotate(double fraction, const Eigen::Vector3d& p) const {
  const double a = fraction * angle_;
  const double a2 = a * a;
  double sine = 0;
  double versine = 0;  // 1 - cos
  if (a2 < 0.25) {
    // Series, to 1e-11; hardly any sensor turns by half a radian between two knots.
    constexpr double s3 = 1.0 / 6, s5 = 1.0 / 20, s7 = 1.0 / 42, s9 = 1.0 / 72;
    constexpr double c4 = 1.0 / 12, c6 = 1.0 / 30, c8 = 1.0 / 56, c10 = 1.0 / 90;
    sine = a * (1 - s3 * a2 * (1 - s5 * a2 * (1 - s7 * a2 * (1 - s9 * a2))));
    versine = 0.5 * a2 * (1 - c4 * a2 * (1 - c6 * a2 * (1 - c8 * a2 * (1 - c10 * a2))));
  } else {
    sine = std::sin(a);
    versine = 1.0 - std::cos(a);
  }
  return rotation_ * p + sine * (first_ * p) + versine * (second_ * p);
}

std::vector<SegmentMotion> segment_motions(const Knots& knots) {
  std::vector<SegmentMotion> motions;
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) motions.emplace_back(knots[i].pose, knots[i + 1].pose);
  return motions;
}

TimeSpan firing_times(const Cloud& cloud) {
  const auto earlier = [](const Point& a, const Point& b) { return a.time < b.time; };
  const auto [first, last] = std::minmax_element(cloud.points.begin(), cloud.points.end(), earlier);
  return {static_cast<double>(first->time), static_cast<double>(last->time)};
}

SegmentTime locate(const Knots& knots, double time) {
  if (knots.size() < 2) return {};
  const auto after = std::upper_bound(knots.begin(), knots.end(), time, [](double t, const Knot& k) { return t < k.time; });
  const auto segment = std::clamp<std::ptrdiff_t>(after - knots.begin() - 1, 0, static_cast<std::ptrdiff_t>(knots.size()) - 2);
  const Knot& begin = knots[static_cast<std::size_t>(segment)];
  const Knot& end = knots[static_cast<std::size_t>(segment) + 1];
  return {static_cast<int>(segment), (time - begin.time) / (end.time - begin.time)};
}

Pose pose_at(const Knots& knots, double time) {
  if (knots.size() < 2) return knots.front().pose;
  const SegmentTime at = locate(knots, time);
  const auto i = static_cast<std::size_t>(at.segment);
  return interpolate(knots[i].pose, knots[i + 1].pose, at.fraction);
}

Pose levelled(const Pose& from, const Pose& to, const Eigen::Vector3d& up) {
  const Eigen::Vector3d turn = so3_log(to.rotation * from.rotation.conjugate());
  const Eigen::Vector3d climb = up.dot(to.translation - from.translation) * up;
  return {so3_exp(up.dot(turn) * up) * from.rotation, to.translation - climb};
}

CloudPtr deskew(const Cloud& cloud, double stamp_time, const Knots& knots) {
  auto result = std::make_shared<Cloud>(cloud);
  const std::vector<SegmentMotion> motions = segment_motions(knots);
  const Pose to_stamp = pose_at(knots, stamp_time).inverse();
  const Eigen::Matrix3d rotation = to_stamp.matrix();
  for (Point& point : result->points) {
    if (!motions.empty() && point.time != 0) {
      const SegmentTime at = locate(knots, stamp_time + static_cast<double>(point.time));
      const SegmentMotion& motion = motions[static_cast<std::size_t>(at.segment)];
      const Eigen::Vector3d p = motion.rotate(at.fraction, point.position().cast<double>()) + motion.origin(at.fraction);
      const Eigen::Vector3f q = (rotation * p + to_stamp.translation).cast<float>();
      point.x = q.x();
      point.y = q.y();
      point.z = q.z();
    }
    point.time = 0;
  }
  return result;
}

}  // namespace sgraph
