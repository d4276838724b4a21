#include <algorithm>
#include <stdexcept>

#include "json_values.hpp"
#include "sgraph_slam/core/util/json_integer.hpp"

namespace sgraph {
namespace {

using Json = nlohmann::json;

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

// Shows a factor's values to JSON.
struct Writer {
  Json& json;

  template <class Id>
  void block(const char* key, const Id& id) {
    json[key] = id.value;
  }
  void blocks(const char* key, PlaneId a, PlaneId b) { json[key] = {a.value, b.value}; }
  void sigma(const char* key, double value) { json[key] = value; }
  void index(const char* key, int value, int) { json[key] = value; }
  template <class Value>
  void choice(const char* key, Value value, std::initializer_list<Value>) {
    json[key] = to_string(value);
  }
  template <class... Any>
  void type(const Any&...) {}  // written as the factor's type
  void field(const char* key, double value) { json[key] = value; }
  void field(const char* key, KeyframeId id) { json[key] = id.value; }
  void field(const char* key, const Pose& value) { json[key] = pose_json(value); }
  void field(const char* key, const Plane& value) { json[key] = plane_json(value); }
  void field(const char* key, const Eigen::Vector3d& value) { json[key] = vector_json<3>(value); }
  void field(const char* key, const SqrtScatter& value) {
    json[key] = {vector_json<4>(value.row(0)), vector_json<4>(value.row(1)), vector_json<4>(value.row(2))};
  }
  template <int N>
  void field(const char* key, const SqrtInformation<N>& value) {
    json[key] = weight_json(value);
  }
};

// Takes a factor's values from JSON. Throws when one is missing or of another kind.
struct Reader {
  const Json& json;

  template <class Id>
  void block(const char* key, Id& id) {
    id = {integer_from(json.at(key))};
  }
  void blocks(const char* key, PlaneId& a, PlaneId& b) {
    a = {integer_from(json.at(key).at(0))};
    b = {integer_from(json.at(key).at(1))};
  }
  void sigma(const char* key, double& value) { field(key, value); }
  void index(const char* key, int& value, int count) {
    const std::int64_t index = integer_from(json.at(key));
    if (index < 0 || index >= count) throw std::runtime_error(std::string(key) + " " + std::to_string(index) + " isn't known");
    value = static_cast<int>(index);
  }
  template <class Value>
  void choice(const char* key, Value& value, std::initializer_list<Value> values) {
    const auto name = json.at(key).template get<std::string>();
    for (const Value one : values) {
      if (name != to_string(one)) continue;
      value = one;
      return;
    }
    throw std::runtime_error("unknown " + std::string(key) + " '" + name + "'");
  }
  template <class Value, class Names>
  void type(Value& value, const Names& names) {
    const auto found = std::find(names.begin(), names.end(), json.at("type").template get_ref<const std::string&>());
    value = static_cast<Value>(found - names.begin());
  }
  void field(const char* key, double& value) { value = json.at(key).get<double>(); }
  void field(const char* key, KeyframeId& id) { block(key, id); }
  void field(const char* key, Pose& value) { value = pose_from(json.at(key)); }
  void field(const char* key, Plane& value) { value = plane_from(json.at(key)); }
  void field(const char* key, Eigen::Vector3d& value) { value = vector_from<3>(json.at(key)); }
  void field(const char* key, SqrtScatter& value) {
    for (int r = 0; r < 3; ++r) value.row(r) = vector_from<4>(json.at(key).at(static_cast<std::size_t>(r)));
  }
  template <int N>
  void field(const char* key, SqrtInformation<N>& value) {
    value = weight_from<N>(json.at(key));
  }
};

template <class Type>
bool is_type_of(const std::string& name) {
  if constexpr (std::is_same_v<Type, Se3Between>) {
    return std::find(Type::source_types.begin(), Type::source_types.end(), name) != Type::source_types.end();
  } else {
    return name == Type::type;
  }
}

template <std::size_t I = 0>
FactorData data_from(const Json& json, const std::string& type) {
  if constexpr (I < std::variant_size_v<FactorData>) {
    using Type = std::variant_alternative_t<I, FactorData>;
    if (is_type_of<Type>(type)) {
      Type data;
      Reader reader{json};
      Type::describe(data, reader);
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
  Writer writer{json};
  std::visit([&writer](const auto& data) { std::decay_t<decltype(data)>::describe(data, writer); }, factor.data);
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
