#include "sgraph_slam/core/graph/factor.hpp"

#include <cmath>
#include <utility>

#include "sgraph_slam/core/graph/value_checks.hpp"

namespace sgraph {
namespace {

// Visitors of a factor's own description; each takes what it wants and passes over the rest.

struct Variables {
  BlockIds ids;

  template <class Id>
  void block(const char*, const Id& id) {
    ids.push_back(id);
  }
  void blocks(const char*, PlaneId a, PlaneId b) {
    ids.push_back(a);
    ids.push_back(b);
  }
  template <class... Any>
  void field(const Any&...) {}
  template <class... Any>
  void sigma(const Any&...) {}
  template <class... Any>
  void index(const Any&...) {}
  template <class Value>
  void choice(const char*, Value, std::initializer_list<Value>) {}
  template <class... Any>
  void type(const Any&...) {}
};

struct Repointed {
  PlaneId from;
  PlaneId to;

  void block(const char*, PlaneId& id) {
    if (id == from) id = to;
  }
  template <class Id>
  void block(const char*, Id&) {}
  void blocks(const char* key, PlaneId& a, PlaneId& b) {
    block(key, a);
    block(key, b);
  }
  template <class... Any>
  void field(const Any&...) {}
  template <class... Any>
  void sigma(const Any&...) {}
  template <class... Any>
  void index(const Any&...) {}
  template <class Value>
  void choice(const char*, Value, std::initializer_list<Value>) {}
  template <class... Any>
  void type(const Any&...) {}
};

struct Validity {
  bool valid = true;

  template <class... Any>
  void block(const Any&...) {}
  template <class... Any>
  void blocks(const Any&...) {}
  void sigma(const char*, double value) { valid = valid && std::isfinite(value) && value > 0; }
  void index(const char*, int value, int limit) { valid = valid && value >= 0 && value < limit; }
  template <class Value>
  void choice(const char*, Value, std::initializer_list<Value>) {}
  template <class... Any>
  void type(const Any&...) {}

  void field(const char*, double value) { valid = valid && std::isfinite(value); }
  void field(const char*, KeyframeId) {}
  void field(const char*, const Pose& value) { valid = valid && sgraph::valid(value); }
  void field(const char*, const Plane& value) { valid = valid && sgraph::valid(value); }
  template <int N>
  void field(const char*, const SqrtInformation<N>& value) {
    valid = valid && value.matrix().allFinite();
  }
  template <class Derived>
  void field(const char*, const Eigen::MatrixBase<Derived>& value) {
    valid = valid && value.allFinite();
  }
};

// Two factors of one type: the first shows its values, the second is compared with them in the same order.
struct Numbers {
  std::vector<double> values;

  void add(double value) { values.push_back(value); }
  template <class Id>
  void block(const char*, const Id& id) {
    add(static_cast<double>(id.value));
  }
  void blocks(const char* key, PlaneId a, PlaneId b) {
    block(key, a);
    block(key, b);
  }
  void sigma(const char*, double value) { add(value); }
  void index(const char*, int value, int) { add(value); }
  template <class Value>
  void choice(const char*, Value value, std::initializer_list<Value>) {
    add(static_cast<double>(value));
  }
  template <class Value, class Names>
  void type(Value value, const Names&) {
    add(static_cast<double>(value));
  }
  void field(const char*, double value) { add(value); }
  void field(const char*, KeyframeId id) { add(static_cast<double>(id.value)); }
  void field(const char* key, const Pose& value) {
    field(key, value.rotation.coeffs());
    field(key, value.translation);
  }
  void field(const char* key, const Plane& value) {
    field(key, value.normal);
    add(value.d);
  }
  template <int N>
  void field(const char* key, const SqrtInformation<N>& value) {
    field(key, value.matrix());
  }
  template <class Derived>
  void field(const char*, const Eigen::MatrixBase<Derived>& matrix) {
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) {
      for (Eigen::Index r = 0; r < matrix.rows(); ++r) add(matrix(r, c));
    }
  }
};

template <class Visitor>
Visitor shown(const FactorData& data, Visitor visitor) {
  std::visit([&visitor](const auto& f) { std::decay_t<decltype(f)>::describe(f, visitor); }, data);
  return visitor;
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

BlockIds blocks(const FactorData& data) { return shown(data, Variables{}).ids; }

const char* type_name(const FactorData& data) {
  if (const auto* between = std::get_if<Se3Between>(&data)) return Se3Between::source_types[static_cast<std::size_t>(between->source)];
  return std::visit([](const auto& f) { return std::decay_t<decltype(f)>::type; }, data);
}

int residual_size(const FactorData& data) {
  return std::visit([](const auto& f) { return std::decay_t<decltype(f)>::residuals; }, data);
}

int residual_rank(const FactorData& data) {
  return std::visit([](const auto& f) { return std::decay_t<decltype(f)>::rank; }, data);
}

bool valid(const Factor& factor) {
  if (factor.loss.kind != LossKind::none && !(std::isfinite(factor.loss.scale) && factor.loss.scale > 0)) return false;
  return shown(factor.data, Validity{}).valid;
}

FactorData repointed(FactorData data, PlaneId from, PlaneId to) {
  Repointed visitor{from, to};
  std::visit([&visitor](auto& f) { std::decay_t<decltype(f)>::describe(f, visitor); }, data);
  return data;
}

bool operator==(const Factor& a, const Factor& b) {
  return a.loss == b.loss && a.data.index() == b.data.index() && shown(a.data, Numbers{}).values == shown(b.data, Numbers{}).values;
}

}  // namespace sgraph
