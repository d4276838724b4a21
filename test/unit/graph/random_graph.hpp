#pragma once

#include <random>

#include "sgraph_slam/core/graph/graph.hpp"
#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph::test {

/// Seeded draws of the values that the factors meet, awkward ones among them.
class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  double normal(double sigma = 1.0) { return sigma * std::normal_distribution<double>()(random_); }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random_); }
  template <int N>
  Eigen::Matrix<double, N, 1> normals(double sigma = 1.0) {
    Eigen::Matrix<double, N, 1> v;
    for (int i = 0; i < N; ++i) v[i] = normal(sigma);
    return v;
  }

  Eigen::Vector3d direction() { return normals<3>().normalized(); }

  /// Any attitude; every fourth a robot's, level with a yaw close to pi.
  Pose pose() {
    Pose T{so3_exp(uniform(0, M_PI - 1e-3) * direction()), normals<3>(10.0)};
    if (below(4) == 0) T.rotation = so3_exp(Eigen::Vector3d(0, 0, (below(2) == 0 ? 1 : -1) * (M_PI - 1e-9 * below(3)))) * so3_exp(normals<3>(0.02));
    return T;
  }

  /// Any plane; among them floors, ceilings, walls along the axes and planes through the origin.
  Plane plane() {
    Plane p{direction(), normal(10.0)};
    switch (below(6)) {
      case 0: p.normal = Eigen::Vector3d(0, 0, below(2) == 0 ? 1 : -1); break;
      case 1: p.normal = (Eigen::Vector3d(0, 0, below(2) == 0 ? 1 : -1) + normals<3>(1e-9)).normalized(); break;
      case 2: p.normal = Eigen::Vector3d::Unit(below(3)); break;
      default: break;
    }
    if (below(4) == 0) p.d = below(2) == 0 ? 0.0 : 1e-12;
    return p;
  }

  Plane near(const Plane& plane, double angle, double distance) {
    return {(plane.normal + tangent_basis(plane.normal) * normals<2>(angle)).normalized(), plane.d + normal(distance)};
  }
  Pose near(const Pose& pose, double sigma) { return pose * se3_exp(normals<6>(sigma)); }

  template <int N>
  Eigen::Matrix<double, N, N> covariance(double scale) {
    Eigen::Matrix<double, N, N> a;
    for (int i = 0; i < N; ++i) a.col(i) = normals<N>(scale);
    return a * a.transpose() + 0.01 * scale * scale * Eigen::Matrix<double, N, N>::Identity();
  }
  template <int N>
  SqrtInformation<N> weight() {
    return SqrtInformation<N>::from_covariance(covariance<N>(0.05), Eigen::Matrix<double, N, 1>::Constant(1e-3));
  }

  Room room() { return Room::at(normals<3>(10.0), uniform(-M_PI, M_PI), Eigen::Vector2d(uniform(3, 9), uniform(3, 9))); }
  Corridor corridor() { return Corridor::at(normals<3>(10.0), uniform(-M_PI, M_PI), uniform(1, 4)); }

  /// Points on the free side of a plane in the LiDAR frame with noise, as their scatter.
  Eigen::Matrix4d scatter(const Plane& plane, double noise, int count = 60) {
    Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
    const auto basis = tangent_basis(plane.normal);
    for (int i = 0; i < count; ++i) {
      Eigen::Vector4d p;
      p << (normal(noise) - plane.d) * plane.normal + basis * Eigen::Vector2d(uniform(-3, 3), uniform(-1, 1)), 1.0;
      sum += p * p.transpose();
    }
    return sum;
  }

 private:
  std::mt19937 random_;
};

}  // namespace sgraph::test
