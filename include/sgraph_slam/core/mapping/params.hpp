#pragma once

#include "sgraph_slam/core/params/visitor.hpp"

namespace sgraph {

struct MappingParams {
  bool topological_layer = true;

  void describe(ParamVisitor& v) { v.field("topological_layer", topological_layer, "Rooms and corridors; off: the paper's \"w/o top. layer\"."); }
};

}  // namespace sgraph
