#pragma once

#include <ceres/cost_function.h>

#include <algorithm>
#include <array>
#include <memory>

#include "random_graph.hpp"

namespace sgraph::test {

/// A factor of each kind and the variables it joins, at seeded values near the measurement or, now and then, far from it.
struct FactorCase {
  Graph graph;
  Factor factor;
};

constexpr int factor_kinds = static_cast<int>(std::variant_size_v<FactorData>);

inline FactorData random_factor(Draw& draw, int kind, const Graph& graph) {
  const KeyframeId a{0};
  const KeyframeId b{1};
  const PlaneId p{0};
  const PlaneId q{1};
  const double far = draw.below(4) == 0 ? 0.4 : 0.01;
  const Pose T_base_lidar = draw.pose();
  const Plane seen = draw.near((*graph.find(a) * T_base_lidar).inverse() * *graph.find(p), far, far);
  const double sigma = draw.uniform(0.005, 0.1);
  switch (kind) {
    case 0:
      return Se3Between{a, b, draw.near(graph.find(a)->inverse() * *graph.find(b), far), draw.weight<6>(),
                        draw.below(2) == 0 ? Se3Between::Source::odometry : Se3Between::Source::loop};
    case 1: return PosePlane{a, p, seen, T_base_lidar, draw.weight<3>()};
    case 2: return PosePlanePoints{a, p, sqrt_scatter(draw.scatter(seen, 0.02), 0.02, 0.002, 0.005), T_base_lidar};
    case 3: return PlanePrior{p, draw.near(*graph.find(p), far, far), draw.weight<3>()};
    case 4: return ParallelPlanes{p, q, sigma};
    case 5: return PerpendicularPlanes{p, q, sigma};
    case 6: return WallThickness{p, q, draw.uniform(0.05, 0.4), sigma, draw.normals<3>(10.0)};
    case 7: return RoomPlane{{0}, p, static_cast<RoomSide>(draw.below(4)), sigma};
    case 8: return CorridorPlane{{0}, p, static_cast<CorridorSide>(draw.below(2)), sigma};
    case 9: return RoomWidth{{0}, a, draw.below(2), draw.uniform(2, 9), sigma};
    case 10: return CorridorWidth{{0}, a, draw.uniform(1, 4), sigma};
    default: return AlignedWalls{p, q, draw.normals<3>(10.0), draw.normals<3>(10.0), draw.uniform(-4, 4), sigma, draw.uniform(0.005, 0.1)};
  }
}

inline FactorCase random_case(Draw& draw, int kind) {
  FactorCase out;
  Transaction t;
  t.keyframes = {{KeyframeId{0}, draw.pose()}, {KeyframeId{1}, draw.pose()}};
  const Plane plane = draw.plane();
  Plane other = draw.plane();
  if (kind >= 4 && kind <= 6 && draw.below(2) == 0) other = {(draw.below(2) == 0 ? 1.0 : -1.0) * plane.normal, draw.normal()};  // exactly parallel
  t.planes = {{PlaneId{0}, plane}, {PlaneId{1}, other}};
  t.rooms = {{RoomId{0}, draw.room()}};
  t.corridors = {{CorridorId{0}, draw.corridor()}};
  out.graph.apply(t);
  out.factor.data = random_factor(draw, kind, out.graph);
  return out;
}

/// A factor's cost as Ceres takes it, to be compared with what Ceres differentiates. Blocks: keyframe `[qx qy qz qw tx ty tz]` on
/// EigenQuaternionManifold x R^3, plane `[n d]` on SphereManifold x R, room and corridor as they are. With the derivative M of our tangent
/// coordinates by the block's, `J_ambient = J_tangent M` is right on the manifold whatever tangent space Ceres uses.
class CeresCost final : public ceres::CostFunction {
 public:
  CeresCost(CostPtr cost, const BlockIds& ids) : cost_(std::move(cost)), ids_(ids) {
    set_num_residuals(cost_->residual_size());
    for (const VariableId& id : ids_) mutable_parameter_block_sizes()->push_back(ambient_size(id));
  }

  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    std::array<Block, 2> values{};
    std::array<Eigen::MatrixXd, 2> tangent;
    std::array<double*, 2> by{};
    for (std::size_t i = 0; i < ids_.size(); ++i) {
      std::copy(x[i], x[i] + ambient_size(ids_[i]), values[i].begin());
      tangent[i].resize(num_residuals(), tangent_size(ids_[i]));
      by[i] = tangent[i].data();
    }
    const std::array<const Block*, 2> pointers{&values[0], &values[1]};
    cost_->compute(pointers.data(), residuals, jacobians == nullptr ? nullptr : by.data());
    for (std::size_t i = 0; jacobians != nullptr && i < ids_.size(); ++i) {
      if (jacobians[i] == nullptr) continue;
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(jacobians[i], num_residuals(), ambient_size(ids_[i])) =
          tangent[i] * minus_jacobian(ids_[i], values[i]);
    }
    return true;
  }

 private:
  static int ambient_size(const VariableId& id) {
    constexpr int sizes[] = {7, 4, 4, 2};
    return sizes[id.index()];
  }

  static Eigen::MatrixXd minus_jacobian(const VariableId& id, const Block& x) {
    Eigen::MatrixXd M = Eigen::MatrixXd::Identity(tangent_size(id), ambient_size(id));
    if (std::holds_alternative<KeyframeId>(id)) {
      const Eigen::Map<const Eigen::Quaterniond> q(x.data());
      const Eigen::Vector3d v = q.vec();
      M.setZero();
      M.topLeftCorner<3, 3>() = 2.0 * (q.w() * Eigen::Matrix3d::Identity() - skew(v));
      M.block<3, 1>(0, 3) = -2.0 * v;
      M.bottomRightCorner<3, 3>() = q.toRotationMatrix().transpose();
    } else if (std::holds_alternative<PlaneId>(id)) {
      M.setZero();
      M.topLeftCorner<2, 3>() = tangent_basis(Eigen::Map<const Eigen::Vector3d>(x.data())).transpose();
      M(2, 3) = 1.0;
    }
    return M;
  }

  CostPtr cost_;
  BlockIds ids_;
};

inline CostPtr own_cost_of(const FactorCase& c) {
  return std::visit(
      [&](const auto& data) {
        using Type = std::decay_t<decltype(data)>;
        if constexpr (std::is_same_v<Type, RoomPlane>) {
          return make_cost(data, *c.graph.find(data.room));
        } else if constexpr (std::is_same_v<Type, CorridorPlane>) {
          return make_cost(data, *c.graph.find(data.corridor));
        } else {
          return make_cost(data);
        }
      },
      c.factor.data);
}

inline std::unique_ptr<ceres::CostFunction> cost_of(const FactorCase& c) {
  return std::make_unique<CeresCost>(own_cost_of(c), blocks(c.factor.data));
}

}  // namespace sgraph::test
