#pragma once

#include <tuple>
#include <utility>

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "sgraph_slam/core/graph/variables.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {

// How each kind of variable lies in a Ceres parameter block, and how a Jacobian in our tangent space (variables.hpp) becomes one in the block's
// ambient coordinates. With the derivative M of the tangent coordinates by the ambient ones (M times the derivative of plus is the identity),
// J_ambient = J_tangent M is right on the manifold whatever tangent space Ceres uses.

struct PoseBlock {
  using Value = Pose;
  static constexpr int ambient = 7;
  static constexpr int tangent = 6;

  static Value read(const double* x) { return {Eigen::Map<const Eigen::Quaterniond>(x), Eigen::Map<const Eigen::Vector3d>(x + 4)}; }

  template <class Tangent, class Ambient>
  static void lift(const Value& pose, const Tangent& j, Ambient& out) {
    const Eigen::Vector3d v = pose.rotation.vec();
    out.template leftCols<3>().noalias() = j.template leftCols<3>() * (2.0 * (pose.rotation.w() * Eigen::Matrix3d::Identity() - skew(v)));
    out.template middleCols<1>(3).noalias() = j.template leftCols<3>() * (-2.0 * v);
    out.template rightCols<3>().noalias() = j.template rightCols<3>() * pose.matrix().transpose();
  }
};

struct PlaneBlock {
  using Value = Plane;
  static constexpr int ambient = 4;
  static constexpr int tangent = 3;

  static Value read(const double* x) { return {Eigen::Map<const Eigen::Vector3d>(x), x[3]}; }

  template <class Tangent, class Ambient>
  static void lift(const Value& plane, const Tangent& j, Ambient& out) {
    out.template leftCols<3>().noalias() = j.template leftCols<2>() * tangent_basis(plane.normal).transpose();
    out.template rightCols<1>() = j.template rightCols<1>();
  }
};

template <int N>
struct EuclideanBlock {
  using Value = Eigen::Matrix<double, N, 1>;
  static constexpr int ambient = N;
  static constexpr int tangent = N;

  static Value read(const double* x) { return Eigen::Map<const Value>(x); }

  template <class Tangent, class Ambient>
  static void lift(const Value&, const Tangent& j, Ambient& out) {
    out = j;
  }
};
using RoomBlock = EuclideanBlock<4>;
using CorridorBlock = EuclideanBlock<2>;

/// Base of the factors' costs: `Derived` has `void evaluate(const Block::Value&..., Residual& e, std::tuple<Matrix<N, Block::tangent>...>* jacobians)
/// const` with Jacobians in our tangent spaces, null when they aren't asked for.
template <class Derived, int N, class... Blocks>
class TangentCost : public ceres::SizedCostFunction<N, Blocks::ambient...> {
 public:
  using Residual = Eigen::Matrix<double, N, 1>;
  using Jacobians = std::tuple<Eigen::Matrix<double, N, Blocks::tangent>...>;

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const final {
    return run(x, residuals, jacobians, std::index_sequence_for<Blocks...>());
  }

 private:
  template <std::size_t... I>
  bool run(double const* const* x, double* residuals, double** jacobians, std::index_sequence<I...>) const {
    const std::tuple<typename Blocks::Value...> values{Blocks::read(x[I])...};
    Residual e;
    Jacobians tangent;
    static_cast<const Derived*>(this)->evaluate(std::get<I>(values)..., e, jacobians == nullptr ? nullptr : &tangent);
    Eigen::Map<Residual> out(residuals);
    out = e;
    if (jacobians != nullptr) (lift<Blocks>(std::get<I>(values), std::get<I>(tangent), jacobians[I]), ...);
    return true;
  }

  template <class Block, class Tangent>
  static void lift(const typename Block::Value& value, const Tangent& tangent, double* out) {
    if (out == nullptr) return;
    Eigen::Map<Eigen::Matrix<double, N, Block::ambient, Eigen::RowMajor>> ambient(out);
    Block::lift(value, tangent, ambient);
  }
};

}  // namespace sgraph
