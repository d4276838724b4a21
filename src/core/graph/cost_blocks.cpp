#include "cost_blocks.hpp"

#include <ceres/cost_function.h>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

using PlusJacobian = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, 7, 6>;

// Derivative of the block by our tangent coordinates.
PlusJacobian plus_jacobian(const VariableId& id, const double* x) {
  if (std::holds_alternative<KeyframeId>(id)) {
    const Eigen::Map<const Eigen::Quaterniond> q(x);
    const Eigen::Vector3d v = q.vec();
    PlusJacobian j = PlusJacobian::Zero(7, 6);
    j.topLeftCorner<3, 3>() = 0.5 * (q.w() * Eigen::Matrix3d::Identity() + skew(v));
    j.block<1, 3>(3, 0) = -0.5 * v.transpose();
    j.bottomRightCorner<3, 3>() = q.toRotationMatrix();
    return j;
  }
  if (std::holds_alternative<PlaneId>(id)) {
    PlusJacobian j = PlusJacobian::Zero(4, 3);
    j.topLeftCorner<3, 2>() = tangent_basis(Eigen::Map<const Eigen::Vector3d>(x));
    j(3, 2) = 1.0;
    return j;
  }
  const int size = tangent_size(id);
  return PlusJacobian::Identity(size, size);
}

}  // namespace

CostPtr make_cost(const FactorData& factor, const Graph& graph) {
  return std::visit(
      [&graph](const auto& data) {
        using Type = std::decay_t<decltype(data)>;
        if constexpr (std::is_same_v<Type, RoomPlane>) {
          return make_cost(data, *graph.find(data.room));
        } else if constexpr (std::is_same_v<Type, CorridorPlane>) {
          return make_cost(data, *graph.find(data.corridor));
        } else {
          return make_cost(data);
        }
      },
      factor);
}

std::unique_ptr<ceres::LossFunction> make_loss(const RobustLoss& loss) {
  switch (loss.kind) {
    case LossKind::none: return nullptr;
    case LossKind::huber: return std::make_unique<ceres::HuberLoss>(loss.scale);
    case LossKind::cauchy: return std::make_unique<ceres::CauchyLoss>(loss.scale);
    case LossKind::tukey: return std::make_unique<ceres::TukeyLoss>(loss.scale);
    case LossKind::geman_mcclure: return std::make_unique<GemanMcClureLoss>(loss.scale);
  }
  return nullptr;
}

void GemanMcClureLoss::Evaluate(double s, double rho[3]) const {
  const double inverse = 1.0 / (squared_scale_ + s);
  const double ratio = squared_scale_ * inverse;
  rho[0] = s * ratio;
  rho[1] = ratio * ratio;
  rho[2] = -2.0 * ratio * ratio * inverse;
}

int block_size(const VariableId& id) {
  constexpr int sizes[] = {7, 4, 4, 2};
  return sizes[id.index()];
}

Block block_of(const Graph& graph, const VariableId& id) {
  Block block{};
  if (const auto* keyframe = std::get_if<KeyframeId>(&id)) {
    const Pose& pose = *graph.find(*keyframe);
    Eigen::Map<Eigen::Vector4d>(block.data()) = pose.rotation.coeffs();
    Eigen::Map<Eigen::Vector3d>(block.data() + 4) = pose.translation;
  } else if (const auto* plane_id = std::get_if<PlaneId>(&id)) {
    const Plane& plane = *graph.find(*plane_id);
    Eigen::Map<Eigen::Vector4d>(block.data()) << plane.normal, plane.d;
  } else if (const auto* room_id = std::get_if<RoomId>(&id)) {
    const Room& room = *graph.find(*room_id);
    Eigen::Map<Eigen::Vector4d>(block.data()) << room.position, room.width;
  } else {
    const Corridor& corridor = *graph.find(std::get<CorridorId>(id));
    Eigen::Map<Eigen::Vector2d>(block.data()) << corridor.position, corridor.width;
  }
  return block;
}

void set_from_block(Graph& graph, const VariableId& id, const Block& block) {
  const double* x = block.data();
  if (const auto* keyframe = std::get_if<KeyframeId>(&id)) {
    graph.set(*keyframe, Pose{Eigen::Map<const Eigen::Quaterniond>(x).normalized(), Eigen::Map<const Eigen::Vector3d>(x + 4)});
  } else if (const auto* plane = std::get_if<PlaneId>(&id)) {
    graph.set(*plane, Plane{Eigen::Map<const Eigen::Vector3d>(x).normalized(), x[3]});
  } else if (const auto* room_id = std::get_if<RoomId>(&id)) {
    Room room = *graph.find(*room_id);
    room.position = Eigen::Map<const Eigen::Vector2d>(x);
    room.width = Eigen::Map<const Eigen::Vector2d>(x + 2);
    graph.set(*room_id, room);
  } else {
    Corridor corridor = *graph.find(std::get<CorridorId>(id));
    corridor.position = x[0];
    corridor.width = x[1];
    graph.set(std::get<CorridorId>(id), corridor);
  }
}

SmallVector residual_of(const Graph& graph, const FactorData& factor) {
  const auto cost = make_cost(factor, graph);
  const BlockIds ids = blocks(factor);
  std::array<Block, 2> values{};
  for (std::size_t i = 0; i < ids.size(); ++i) values[i] = block_of(graph, ids[i]);
  const std::array<const double*, 2> x{values[0].data(), values[1].data()};
  SmallVector residual(cost->num_residuals());
  cost->Evaluate(x.data(), residual.data(), nullptr);
  return residual;
}

Linearization linearize(const Graph& graph, const FactorData& factor) {
  using Ambient = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;
  const auto cost = make_cost(factor, graph);
  const BlockIds ids = blocks(factor);
  std::array<Block, 2> values{};
  for (std::size_t i = 0; i < ids.size(); ++i) values[i] = block_of(graph, ids[i]);
  const std::array<const double*, 2> x{values[0].data(), values[1].data()};
  std::array<std::array<double, 42>, 2> ambient;
  std::array<double*, 2> ambient_data{ambient[0].data(), ambient[1].data()};
  Linearization out;
  out.residual.resize(cost->num_residuals());
  cost->Evaluate(x.data(), out.residual.data(), ambient_data.data());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    out.jacobians[i] = Ambient(ambient_data[i], cost->num_residuals(), block_size(ids[i])) * plus_jacobian(ids[i], x[i]);
  }
  return out;
}

}  // namespace sgraph
