#include "sgraph_slam/core/graph/factor.hpp"

#include <cmath>

#include "sgraph_slam/core/graph/value_checks.hpp"

namespace sgraph {
namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

template <int N>
bool usable(const SqrtInformation<N>& weight) {
  return weight.matrix().allFinite();
}
bool usable_sigma(double sigma) { return std::isfinite(sigma) && sigma > 0; }

bool same(const Se3Between& a, const Se3Between& b) {
  return a.from == b.from && a.to == b.to && same(a.T_from_to, b.T_from_to) && a.weight == b.weight && a.source == b.source;
}
bool same(const PosePlane& a, const PosePlane& b) {
  return a.keyframe == b.keyframe && a.plane == b.plane && same(a.measured, b.measured) && same(a.T_base_lidar, b.T_base_lidar) &&
         a.weight == b.weight;
}
bool same(const PosePlanePoints& a, const PosePlanePoints& b) {
  return a.keyframe == b.keyframe && a.plane == b.plane && a.points == b.points && same(a.T_base_lidar, b.T_base_lidar);
}
bool same(const PlanePrior& a, const PlanePrior& b) { return a.plane == b.plane && same(a.prior, b.prior) && a.weight == b.weight; }
bool same(const ParallelPlanes& a, const ParallelPlanes& b) { return a.a == b.a && a.b == b.b && a.sigma == b.sigma; }
bool same(const PerpendicularPlanes& a, const PerpendicularPlanes& b) { return a.a == b.a && a.b == b.b && a.sigma == b.sigma; }
bool same(const WallThickness& a, const WallThickness& b) {
  return a.a == b.a && a.b == b.b && a.thickness == b.thickness && a.sigma == b.sigma && a.point == b.point;
}
bool same(const RoomPlane& a, const RoomPlane& b) { return a.room == b.room && a.plane == b.plane && a.side == b.side && a.sigma == b.sigma; }
bool same(const CorridorPlane& a, const CorridorPlane& b) {
  return a.corridor == b.corridor && a.plane == b.plane && a.side == b.side && a.sigma == b.sigma;
}
bool same(const RoomWidth& a, const RoomWidth& b) {
  return a.room == b.room && a.keyframe == b.keyframe && a.axis == b.axis && a.measured == b.measured && a.sigma == b.sigma;
}
bool same(const CorridorWidth& a, const CorridorWidth& b) {
  return a.corridor == b.corridor && a.keyframe == b.keyframe && a.measured == b.measured && a.sigma == b.sigma;
}

}  // namespace

const char* to_string(RoomSide value) {
  switch (value) {
    case RoomSide::x_low: return "x_low";
    case RoomSide::x_high: return "x_high";
    case RoomSide::y_low: return "y_low";
    case RoomSide::y_high: return "y_high";
  }
  return "?";
}

const char* to_string(CorridorSide value) { return value == CorridorSide::right ? "right" : "left"; }

BlockIds blocks(const FactorData& data) {
  using Ids = BlockIds;
  return std::visit(Overloaded{[](const Se3Between& f) {
                                 return Ids{f.from, f.to};
                               },
                               [](const PosePlane& f) {
                                 return Ids{f.keyframe, f.plane};
                               },
                               [](const PosePlanePoints& f) {
                                 return Ids{f.keyframe, f.plane};
                               },
                               [](const PlanePrior& f) { return Ids{f.plane}; },
                               [](const ParallelPlanes& f) {
                                 return Ids{f.a, f.b};
                               },
                               [](const PerpendicularPlanes& f) {
                                 return Ids{f.a, f.b};
                               },
                               [](const WallThickness& f) {
                                 return Ids{f.a, f.b};
                               },
                               [](const RoomPlane& f) {
                                 return Ids{f.room, f.plane};
                               },
                               [](const CorridorPlane& f) {
                                 return Ids{f.corridor, f.plane};
                               },
                               [](const RoomWidth& f) { return Ids{f.room}; }, [](const CorridorWidth& f) { return Ids{f.corridor}; }},
                    data);
}

const char* type_name(const FactorData& data) {
  if (const auto* between = std::get_if<Se3Between>(&data)) return between->source == Se3Between::Source::loop ? "loop" : "se3_between";
  constexpr const char* names[] = {"se3_between",    "pose_plane", "pose_plane_points", "plane_prior", "parallel_planes", "perpendicular_planes",
                                   "wall_thickness", "room_plane", "corridor_plane",    "room_width",  "corridor_width"};
  return names[data.index()];
}

int residual_size(const FactorData& data) {
  constexpr int sizes[] = {6, 3, 3, 3, 3, 1, 1, 1, 1, 1, 1};
  return sizes[data.index()];
}

int residual_rank(const FactorData& data) { return std::holds_alternative<ParallelPlanes>(data) ? 2 : residual_size(data); }

bool valid(const Factor& factor) {
  if (factor.loss.kind != LossKind::none && !usable_sigma(factor.loss.scale)) return false;
  return std::visit(
      Overloaded{[](const Se3Between& f) { return valid(f.T_from_to) && usable(f.weight); },
                 [](const PosePlane& f) { return valid(f.measured) && valid(f.T_base_lidar) && usable(f.weight); },
                 [](const PosePlanePoints& f) { return f.points.allFinite() && valid(f.T_base_lidar); },
                 [](const PlanePrior& f) { return valid(f.prior) && usable(f.weight); },
                 [](const ParallelPlanes& f) { return usable_sigma(f.sigma); }, [](const PerpendicularPlanes& f) { return usable_sigma(f.sigma); },
                 [](const WallThickness& f) { return usable_sigma(f.sigma) && std::isfinite(f.thickness) && f.point.allFinite(); },
                 [](const RoomPlane& f) { return usable_sigma(f.sigma); }, [](const CorridorPlane& f) { return usable_sigma(f.sigma); },
                 [](const RoomWidth& f) { return usable_sigma(f.sigma) && std::isfinite(f.measured) && (f.axis == 0 || f.axis == 1); },
                 [](const CorridorWidth& f) { return usable_sigma(f.sigma) && std::isfinite(f.measured); }},
      factor.data);
}

FactorData repointed(FactorData data, PlaneId from, PlaneId to) {
  const auto move = [from, to](PlaneId& id) {
    if (id == from) id = to;
  };
  std::visit(Overloaded{[&](PosePlane& f) { move(f.plane); }, [&](PosePlanePoints& f) { move(f.plane); }, [&](PlanePrior& f) { move(f.plane); },
                        [&](RoomPlane& f) { move(f.plane); }, [&](CorridorPlane& f) { move(f.plane); },
                        [&](ParallelPlanes& f) {
                          move(f.a);
                          move(f.b);
                        },
                        [&](PerpendicularPlanes& f) {
                          move(f.a);
                          move(f.b);
                        },
                        [&](WallThickness& f) {
                          move(f.a);
                          move(f.b);
                        },
                        [](auto&) {}},
             data);
  return data;
}

bool operator==(const Factor& a, const Factor& b) {
  if (!(a.loss == b.loss) || a.data.index() != b.data.index()) return false;
  return std::visit(
      [&b](const auto& data) {
        using Type = std::decay_t<decltype(data)>;
        return same(data, std::get<Type>(b.data));
      },
      a.data);
}

}  // namespace sgraph
