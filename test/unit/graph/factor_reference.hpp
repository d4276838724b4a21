#pragma once

#include <ceres/jet.h>

#include <Eigen/Geometry>

#include "sgraph_slam/core/graph/graph.hpp"

namespace sgraph::test {

/// The factors' equations as their headers state them, for automatic differentiation: written a second time, with rotation matrices and homogeneous
/// planes.
struct FactorReference {
  FactorData data;
  Room room;
  Corridor corridor;

  template <class T>
  using V3 = Eigen::Matrix<T, 3, 1>;
  template <class T>
  using M4 = Eigen::Matrix<T, 4, 4>;

  template <class T>
  static M4<T> transform(const Eigen::Quaternion<T>& q, const V3<T>& t) {
    M4<T> m = M4<T>::Identity();
    m.template topLeftCorner<3, 3>() = q.toRotationMatrix();
    m.template topRightCorner<3, 1>() = t;
    return m;
  }
  template <class T>
  static M4<T> transform(const T* x) {
    return transform<T>(Eigen::Quaternion<T>(x[3], x[0], x[1], x[2]), V3<T>(x[4], x[5], x[6]));
  }
  template <class T>
  static M4<T> transform(const Pose& pose) {
    return transform<T>(pose.rotation.cast<T>(), pose.translation.cast<T>());
  }

  /// Logarithm [rotation; translation]: the angle by atan2, the translation by solving V rho = t.
  template <class T>
  static Eigen::Matrix<T, 6, 1> log(const Eigen::Quaternion<T>& q_any, const V3<T>& t) {
    Eigen::Quaternion<T> q = q_any;
    if (q.w() < T(0)) q.coeffs() *= T(-1);
    const V3<T> v = q.vec();
    const T s2 = v.squaredNorm();
    V3<T> phi = T(2) * v;
    T a = T(0.5) - s2 / T(6);  // (1 - cos) / angle^2 and (angle - sin) / angle^3
    T b = T(1.0 / 6) - s2 / T(30);
    if (s2 > T(1e-8)) {
      const T s = sqrt(s2);
      const T angle = T(2) * atan2(s, q.w());
      phi = (angle / s) * v;
      a = (T(1) - cos(angle)) / (angle * angle);
      b = (angle - sin(angle)) / (angle * angle * angle);
    }
    Eigen::Matrix<T, 3, 3> w;
    w << T(0), -phi[2], phi[1], phi[2], T(0), -phi[0], -phi[1], phi[0], T(0);
    const Eigen::Matrix<T, 3, 3> V = Eigen::Matrix<T, 3, 3>::Identity() + a * w + b * w * w;
    Eigen::Matrix<T, 6, 1> out;
    out << phi, V.inverse() * t;
    return out;
  }

  template <class T>
  static Eigen::Matrix<T, 4, 1> seen_plane(const T* pose, const T* plane, const Pose& T_base_lidar) {
    return (transform<T>(pose) * transform<T>(T_base_lidar)).transpose() * Eigen::Matrix<T, 4, 1>(plane[0], plane[1], plane[2], plane[3]);
  }
  template <class T>
  static Eigen::Matrix<T, 3, 1> tangent_difference(const Plane& measured, const Eigen::Matrix<T, 4, 1>& plane) {
    Eigen::Matrix<T, 3, 1> e;
    e << tangent_basis(measured.normal).transpose().cast<T>() * plane.template head<3>(), plane[3] - T(measured.d);
    return e;
  }

  template <class T>
  bool operator()(T const* const* x, T* e) const {
    std::visit([&](const auto& f) { evaluate(f, x, e); }, data);
    return true;
  }

  template <class T>
  void evaluate(const Se3Between& f, T const* const* x, T* e) const {
    const auto quaternion = [](const T* q) { return Eigen::Quaternion<T>(q[3], q[0], q[1], q[2]); };
    const auto position = [](const T* q) { return V3<T>(q[4], q[5], q[6]); };
    const Eigen::Quaternion<T> q_z = f.T_from_to.rotation.cast<T>();
    const Eigen::Quaternion<T> q = q_z.conjugate() * (quaternion(x[0]).conjugate() * quaternion(x[1]));
    const V3<T> t = q_z.conjugate() * (quaternion(x[0]).conjugate() * (position(x[1]) - position(x[0])) - f.T_from_to.translation.cast<T>());
    Eigen::Map<Eigen::Matrix<T, 6, 1>> out(e);
    out = f.weight.matrix().cast<T>() * log<T>(q, t);
  }
  template <class T>
  void evaluate(const PosePlane& f, T const* const* x, T* e) const {
    Eigen::Map<V3<T>> out(e);
    out = f.weight.matrix().cast<T>() * tangent_difference<T>(f.measured, seen_plane(x[0], x[1], f.T_base_lidar));
  }
  template <class T>
  void evaluate(const PosePlanePoints& f, T const* const* x, T* e) const {
    Eigen::Map<V3<T>> out(e);
    out = f.points.cast<T>() * seen_plane(x[0], x[1], f.T_base_lidar);
  }
  template <class T>
  void evaluate(const PlanePrior& f, T const* const* x, T* e) const {
    Eigen::Map<V3<T>> out(e);
    out = f.weight.matrix().cast<T>() * tangent_difference<T>(f.prior, Eigen::Map<const Eigen::Matrix<T, 4, 1>>(x[0]));
  }
  template <class T>
  void evaluate(const ParallelPlanes& f, T const* const* x, T* e) const {
    const T* a = x[0];
    const T* b = x[1];
    e[0] = (a[1] * b[2] - a[2] * b[1]) / T(f.sigma);
    e[1] = (a[2] * b[0] - a[0] * b[2]) / T(f.sigma);
    e[2] = (a[0] * b[1] - a[1] * b[0]) / T(f.sigma);
  }
  template <class T>
  void evaluate(const PerpendicularPlanes& f, T const* const* x, T* e) const {
    e[0] = (x[0][0] * x[1][0] + x[0][1] * x[1][1] + x[0][2] * x[1][2]) / T(f.sigma);
  }
  template <class T>
  static T distance(const T* plane, const V3<T>& p) {
    return plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] + plane[3];
  }
  template <class T>
  void evaluate(const WallThickness& f, T const* const* x, T* e) const {
    const V3<T> p = f.point.cast<T>();
    e[0] = (-distance(x[0], p) - distance(x[1], p) - T(f.thickness)) / T(f.sigma);
  }
  template <class T>
  void evaluate(const AlignedWalls& f, T const* const* x, T* e) const {
    const Eigen::Vector3d up(0, 0, f.rise);
    const T from = distance(x[0], f.from.cast<T>().eval()) - distance(x[1], (f.from + up).cast<T>().eval());
    const T to = distance(x[0], f.to.cast<T>().eval()) - distance(x[1], (f.to + up).cast<T>().eval());
    e[0] = (from + to) / T(std::sqrt(2.0) * f.shift_sigma);
    e[1] = (from - to) / T(std::sqrt(2.0) * f.sigma);
  }
  template <class T>
  void evaluate(const RoomPlane& f, T const* const* x, T* e) const {
    const T c = T(std::cos(room.yaw));
    const T s = T(std::sin(room.yaw));
    const V3<T> center(c * x[0][0] - s * x[0][1], s * x[0][0] + c * x[0][1], T(room.z));
    const T width = f.side == RoomSide::x_low || f.side == RoomSide::x_high ? x[0][2] : x[0][3];
    e[0] = (distance(x[1], center) - width / T(2)) / T(f.sigma);
  }
  template <class T>
  void evaluate(const CorridorPlane& f, T const* const* x, T* e) const {
    const T c = T(std::cos(corridor.yaw));
    const T s = T(std::sin(corridor.yaw));
    const T along = T(corridor.along);
    const V3<T> center(c * along - s * x[0][0], s * along + c * x[0][0], T(corridor.z));
    e[0] = (distance(x[1], center) - x[0][1] / T(2)) / T(f.sigma);
  }
  template <class T>
  void evaluate(const RoomWidth& f, T const* const* x, T* e) const {
    e[0] = (x[0][2 + f.axis] - T(f.measured)) / T(f.sigma);
  }
  template <class T>
  void evaluate(const CorridorWidth& f, T const* const* x, T* e) const {
    e[0] = (x[0][1] - T(f.measured)) / T(f.sigma);
  }
};

}  // namespace sgraph::test
