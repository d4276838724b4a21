// Evaluation of each factor: residual alone, and with Jacobians as the solver asks for them.

#include <benchmark/benchmark.h>

#include <array>

#include "unit/graph/factor_cases.hpp"

namespace sgraph {
namespace {

// Blocks of 7 numbers hold any variable.
std::vector<Block> values_of(const test::FactorCase& c) {
  std::vector<Block> out;
  for (const VariableId& id : blocks(c.factor.data)) {
    Block x{};
    if (const auto* keyframe = std::get_if<KeyframeId>(&id)) {
      const Pose& pose = *c.graph.find(*keyframe);
      Eigen::Map<Eigen::Vector4d>(x.data()) = pose.rotation.coeffs();
      Eigen::Map<Eigen::Vector3d>(x.data() + 4) = pose.translation;
    } else if (const auto* plane_id = std::get_if<PlaneId>(&id)) {
      const Plane& plane = *c.graph.find(*plane_id);
      Eigen::Map<Eigen::Vector4d>(x.data()) << plane.normal, plane.d;
    } else if (const auto* room_id = std::get_if<RoomId>(&id)) {
      const Room& room = *c.graph.find(*room_id);
      Eigen::Map<Eigen::Vector4d>(x.data()) << room.position, room.width;
    } else {
      const Corridor& corridor = *c.graph.find(std::get<CorridorId>(id));
      x = {corridor.position, corridor.width};
    }
    out.push_back(x);
  }
  return out;
}

void evaluate(benchmark::State& state, int kind, bool with_jacobians) {
  test::Draw draw(1);
  const test::FactorCase c = test::random_case(draw, kind);
  const CostPtr cost = test::own_cost_of(c);
  const auto values = values_of(c);
  std::vector<const Block*> x;
  std::vector<std::array<double, 42>> storage(values.size());
  std::vector<double*> jacobians;
  for (const Block& v : values) x.push_back(&v);
  for (auto& j : storage) jacobians.push_back(j.data());
  std::array<double, 6> residual{};
  for (auto _ : state) {
    cost->compute(x.data(), residual.data(), with_jacobians ? jacobians.data() : nullptr);
    benchmark::DoNotOptimize(residual);
    benchmark::ClobberMemory();
  }
}

const bool registered = [] {
  for (int kind = 0; kind < test::factor_kinds; ++kind) {
    test::Draw draw(1);
    const std::string name = type_name(test::random_case(draw, kind).factor.data);
    benchmark::RegisterBenchmark((name + "/residual").c_str(), evaluate, kind, false);
    benchmark::RegisterBenchmark((name + "/jacobians").c_str(), evaluate, kind, true);
  }
  return true;
}();

}  // namespace
}  // namespace sgraph
