#pragma once

#include <tuple>
#include <utility>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "sgraph_slam/core/graph/factors/cost.hpp"
#include "sgraph_slam/core/graph/variables.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {

// How each kind of variable is read from a block.

struct PoseBlock {
  using Value = Pose;
  static constexpr int tangent = 6;
  static Value read(const Block& x) { return {Eigen::Map<const Eigen::Quaterniond>(x.data()), Eigen::Map<const Eigen::Vector3d>(x.data() + 4)}; }
};

struct PlaneBlock {
  using Value = Plane;
  static constexpr int tangent = 3;
  static Value read(const Block& x) { return {Eigen::Map<const Eigen::Vector3d>(x.data()), x[3]}; }
};

template <int N>
struct EuclideanBlock {
  using Value = Eigen::Matrix<double, N, 1>;
  static constexpr int tangent = N;
  static Value read(const Block& x) { return Eigen::Map<const Value>(x.data()); }
};
using RoomBlock = EuclideanBlock<4>;
using CorridorBlock = EuclideanBlock<2>;

/// Base of the factors' costs: `Derived` has `void evaluate(const Block::Value&..., Residual& e, std::tuple<Matrix<N, Block::tangent>...>* jacobians)
/// const` with Jacobians in our tangent spaces, null when they aren't asked for.
template <class Derived, int N, class... Blocks>
class TangentCost : public FactorCost {
 public:
  using Residual = Eigen::Matrix<double, N, 1>;
  using Jacobians = std::tuple<Eigen::Matrix<double, N, Blocks::tangent>...>;

  [[nodiscard]] int residual_size() const final { return N; }

  void compute(const Block* const* x, double* e, double* const* jacobians) const final { run(x, e, jacobians, std::index_sequence_for<Blocks...>()); }

 private:
  template <std::size_t... I>
  void run(const Block* const* x, double* residual, double* const* jacobians, std::index_sequence<I...>) const {
    Residual e;
    Jacobians tangent;
    static_cast<const Derived*>(this)->evaluate(Blocks::read(*x[I])..., e, jacobians == nullptr ? nullptr : &tangent);
    Eigen::Map<Residual> out(residual);
    out = e;
    if (jacobians == nullptr) return;
    (copy(std::get<I>(tangent), jacobians[I]), ...);
  }

  template <class Matrix>
  static void copy(const Matrix& from, double* to) {
    Eigen::Map<Eigen::MatrixXd>(to, from.rows(), from.cols()) = from;
  }
};

}  // namespace sgraph
