#include <stdexcept>

#include "json_values.hpp"

namespace sgraph {
namespace {

using Json = nlohmann::json;

template <class Kind>
Id<Kind> id_from(const Json& json, const char* key) {
  return {json.at(key).get<std::int64_t>()};
}

// Upper triangle, row by row.
template <int N>
Json weight_json(const SqrtInformation<N>& weight) {
  Json out = Json::array();
  for (int r = 0; r < N; ++r) {
    for (int c = r; c < N; ++c) out.push_back(weight.matrix()(r, c));
  }
  return out;
}

template <int N>
SqrtInformation<N> weight_from(const Json& json) {
  const auto numbers = vector_from<N*(N + 1) / 2>(json);
  typename SqrtInformation<N>::Matrix m = SqrtInformation<N>::Matrix::Zero();
  for (int r = 0, i = 0; r < N; ++r) {
    for (int c = r; c < N; ++c) m(r, c) = numbers[i++];
  }
  return SqrtInformation<N>::from_factor(m);
}

void write(Json& j, const Se3Between& f) {
  j["from"] = f.from.value;
  j["to"] = f.to.value;
  j["pose"] = pose_json(f.T_from_to);
  j["sqrt_information"] = weight_json(f.weight);
}
void read(const Json& j, Se3Between& f) {
  f.from = id_from<KeyframeKind>(j, "from");
  f.to = id_from<KeyframeKind>(j, "to");
  f.T_from_to = pose_from(j.at("pose"));
  f.weight = weight_from<6>(j.at("sqrt_information"));
  f.source = j.at("type") == "loop" ? Se3Between::Source::loop : Se3Between::Source::odometry;
}

void write(Json& j, const PosePlane& f) {
  j["keyframe"] = f.keyframe.value;
  j["plane"] = f.plane.value;
  j["measured"] = plane_json(f.measured);
  j["base_lidar"] = pose_json(f.T_base_lidar);
  j["sqrt_information"] = weight_json(f.weight);
}
void read(const Json& j, PosePlane& f) {
  f.keyframe = id_from<KeyframeKind>(j, "keyframe");
  f.plane = id_from<PlaneKind>(j, "plane");
  f.measured = plane_from(j.at("measured"));
  f.T_base_lidar = pose_from(j.at("base_lidar"));
  f.weight = weight_from<3>(j.at("sqrt_information"));
}

void write(Json& j, const PosePlanePoints& f) {
  j["keyframe"] = f.keyframe.value;
  j["plane"] = f.plane.value;
  j["sqrt_scatter"] = {vector_json<4>(f.points.row(0)), vector_json<4>(f.points.row(1)), vector_json<4>(f.points.row(2))};
  j["base_lidar"] = pose_json(f.T_base_lidar);
}
void read(const Json& j, PosePlanePoints& f) {
  f.keyframe = id_from<KeyframeKind>(j, "keyframe");
  f.plane = id_from<PlaneKind>(j, "plane");
  for (int r = 0; r < 3; ++r) f.points.row(r) = vector_from<4>(j.at("sqrt_scatter").at(static_cast<std::size_t>(r)));
  f.T_base_lidar = pose_from(j.at("base_lidar"));
}

void write(Json& j, const PlanePrior& f) {
  j["plane"] = f.plane.value;
  j["prior"] = plane_json(f.prior);
  j["sqrt_information"] = weight_json(f.weight);
}
void read(const Json& j, PlanePrior& f) {
  f.plane = id_from<PlaneKind>(j, "plane");
  f.prior = plane_from(j.at("prior"));
  f.weight = weight_from<3>(j.at("sqrt_information"));
}

template <class Pair>
void write_pair(Json& j, const Pair& f) {
  j["planes"] = {f.a.value, f.b.value};
  j["sigma"] = f.sigma;
}
template <class Pair>
void read_pair(const Json& j, Pair& f) {
  f.a = {j.at("planes").at(0).get<std::int64_t>()};
  f.b = {j.at("planes").at(1).get<std::int64_t>()};
  f.sigma = j.at("sigma").get<double>();
}
void write(Json& j, const ParallelPlanes& f) { write_pair(j, f); }
void read(const Json& j, ParallelPlanes& f) { read_pair(j, f); }
void write(Json& j, const PerpendicularPlanes& f) { write_pair(j, f); }
void read(const Json& j, PerpendicularPlanes& f) { read_pair(j, f); }

void write(Json& j, const WallThickness& f) {
  write_pair(j, f);
  j["thickness"] = f.thickness;
  j["point"] = vector_json<3>(f.point);
}
void read(const Json& j, WallThickness& f) {
  read_pair(j, f);
  f.thickness = j.at("thickness").get<double>();
  f.point = vector_from<3>(j.at("point"));
}

template <class Side>
Side side_from(const Json& j, std::initializer_list<Side> sides) {
  const auto name = j.at("side").get<std::string>();
  for (const Side side : sides) {
    if (name == to_string(side)) return side;
  }
  throw std::runtime_error("unknown side '" + name + "'");
}

void write(Json& j, const RoomPlane& f) {
  j["room"] = f.room.value;
  j["plane"] = f.plane.value;
  j["side"] = to_string(f.side);
  j["sigma"] = f.sigma;
}
void read(const Json& j, RoomPlane& f) {
  f.room = id_from<RoomKind>(j, "room");
  f.plane = id_from<PlaneKind>(j, "plane");
  f.side = side_from(j, {RoomSide::x_low, RoomSide::x_high, RoomSide::y_low, RoomSide::y_high});
  f.sigma = j.at("sigma").get<double>();
}

void write(Json& j, const CorridorPlane& f) {
  j["corridor"] = f.corridor.value;
  j["plane"] = f.plane.value;
  j["side"] = to_string(f.side);
  j["sigma"] = f.sigma;
}
void read(const Json& j, CorridorPlane& f) {
  f.corridor = id_from<CorridorKind>(j, "corridor");
  f.plane = id_from<PlaneKind>(j, "plane");
  f.side = side_from(j, {CorridorSide::right, CorridorSide::left});
  f.sigma = j.at("sigma").get<double>();
}

void write(Json& j, const RoomWidth& f) {
  j["room"] = f.room.value;
  j["keyframe"] = f.keyframe.value;
  j["axis"] = f.axis;
  j["measured"] = f.measured;
  j["sigma"] = f.sigma;
}
void read(const Json& j, RoomWidth& f) {
  f.room = id_from<RoomKind>(j, "room");
  f.keyframe = id_from<KeyframeKind>(j, "keyframe");
  f.axis = j.at("axis").get<int>();
  f.measured = j.at("measured").get<double>();
  f.sigma = j.at("sigma").get<double>();
}

void write(Json& j, const CorridorWidth& f) {
  j["corridor"] = f.corridor.value;
  j["keyframe"] = f.keyframe.value;
  j["measured"] = f.measured;
  j["sigma"] = f.sigma;
}
void read(const Json& j, CorridorWidth& f) {
  f.corridor = id_from<CorridorKind>(j, "corridor");
  f.keyframe = id_from<KeyframeKind>(j, "keyframe");
  f.measured = j.at("measured").get<double>();
  f.sigma = j.at("sigma").get<double>();
}

template <std::size_t I = 0>
FactorData data_from(const Json& json, const std::string& type) {
  if constexpr (I < std::variant_size_v<FactorData>) {
    std::variant_alternative_t<I, FactorData> data;
    if (type == type_name(FactorData(data)) || (I == 0 && type == "loop")) {
      read(json, data);
      return data;
    }
    return data_from<I + 1>(json, type);
  } else {
    throw std::runtime_error("unknown factor type '" + type + "'");
  }
}

}  // namespace

Json factor_json(FactorId id, const Factor& factor) {
  Json json;
  json["id"] = id.value;
  json["type"] = type_name(factor.data);
  if (factor.loss.kind != LossKind::none) json["loss"] = {{"kind", to_string(factor.loss.kind)}, {"scale", factor.loss.scale}};
  std::visit([&json](const auto& data) { write(json, data); }, factor.data);
  return json;
}

Factor factor_from(const Json& json) {
  Factor factor;
  factor.data = data_from(json, json.at("type").get<std::string>());
  if (json.contains("loss")) {
    factor.loss.kind = loss_kind_from(json.at("loss").at("kind").get<std::string>());
    factor.loss.scale = json.at("loss").at("scale").get<double>();
  }
  return factor;
}

}  // namespace sgraph
