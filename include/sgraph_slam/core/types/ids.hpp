#pragma once

#include <cstdint>

namespace sgraph {

/// A number that names one thing of one kind; kinds don't mix. Ids count up from 0 in order of arrival and are never used twice.
template <class Kind>
struct Id {
  std::int64_t value = -1;

  [[nodiscard]] bool valid() const { return value >= 0; }
  friend bool operator==(Id a, Id b) { return a.value == b.value; }
  friend bool operator!=(Id a, Id b) { return a.value != b.value; }
  friend bool operator<(Id a, Id b) { return a.value < b.value; }
};

using KeyframeId = Id<struct KeyframeKind>;
using PlaneId = Id<struct PlaneKind>;
using RoomId = Id<struct RoomKind>;
using CorridorId = Id<struct CorridorKind>;
using FactorId = Id<struct FactorKind>;

}  // namespace sgraph
