#include "cost_blocks.hpp"

#include <type_traits>
#include <utility>

#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {

namespace {

// Factors that need the constants of a place name it.
template <class Type, class = void>
struct NeedsConstants : std::false_type {};
template <class Type>
struct NeedsConstants<Type, std::void_t<decltype(std::declval<const Type&>().constants_of())>> : std::true_type {};

}  // namespace

CostPtr make_cost(const FactorData& factor, const Graph& graph) {
  return std::visit(
      [&graph](const auto& data) {
        if constexpr (NeedsConstants<std::decay_t<decltype(data)>>::value) {
          return make_cost(data, *graph.find(data.constants_of()));
        } else {
          return make_cost(data);
        }
      },
      factor);
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

Block moved(const VariableId& id, const Block& block, const double* step) {
  Block out = block;
  if (std::holds_alternative<KeyframeId>(id)) {
    const Eigen::Map<const Eigen::Quaterniond> q(block.data());
    const Eigen::Map<const Eigen::Vector3d> rotation(step);
    const Eigen::Map<const Eigen::Vector3d> translation(step + 3);
    Eigen::Map<Eigen::Vector4d>(out.data()) = (q * so3_exp(rotation)).normalized().coeffs();
    Eigen::Map<Eigen::Vector3d>(out.data() + 4) += q * translation;
  } else if (std::holds_alternative<PlaneId>(id)) {
    const Eigen::Vector3d n = Eigen::Map<const Eigen::Vector3d>(block.data());
    Eigen::Map<Eigen::Vector3d>(out.data()) = (n + tangent_basis(n) * Eigen::Map<const Eigen::Vector2d>(step)).normalized();
    out[3] += step[2];
  } else {
    for (int i = 0; i < tangent_size(id); ++i) out[static_cast<std::size_t>(i)] += step[i];
  }
  return out;
}

namespace {

// Values of a factor's blocks, and pointers to them as costs take them.
struct BlocksOf {
  BlocksOf(const Graph& graph, const BlockIds& ids) {
    for (std::size_t i = 0; i < ids.size(); ++i) values[i] = block_of(graph, ids[i]);
  }
  std::array<Block, 2> values{};
  std::array<const Block*, 2> pointers{&values[0], &values[1]};
};

}  // namespace

SmallVector residual_of(const Graph& graph, const FactorData& factor) {
  const auto cost = make_cost(factor, graph);
  const BlocksOf x(graph, blocks(factor));
  SmallVector residual(cost->residual_size());
  cost->compute(x.pointers.data(), residual.data(), nullptr);
  return residual;
}

Linearization linearize(const Graph& graph, const FactorData& factor) {
  const auto cost = make_cost(factor, graph);
  const BlockIds ids = blocks(factor);
  const BlocksOf x(graph, ids);
  Linearization out;
  out.residual.resize(cost->residual_size());
  std::array<double*, 2> jacobians{};
  for (std::size_t i = 0; i < ids.size(); ++i) {
    out.jacobians[i].resize(cost->residual_size(), tangent_size(ids[i]));
    jacobians[i] = out.jacobians[i].data();
  }
  cost->compute(x.pointers.data(), out.residual.data(), jacobians.data());
  return out;
}

}  // namespace sgraph
