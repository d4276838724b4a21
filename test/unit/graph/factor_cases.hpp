#pragma once

#include <ceres/cost_function.h>

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
    default: return CorridorWidth{{0}, a, draw.uniform(1, 4), sigma};
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

inline CostPtr cost_of(const FactorCase& c) {
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

}  // namespace sgraph::test
