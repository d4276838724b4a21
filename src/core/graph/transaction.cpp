#include "sgraph_slam/core/graph/transaction.hpp"

namespace sgraph {

const char* to_string(Refusal value) {
  switch (value) {
    case Refusal::none: return "none";
    case Refusal::duplicate_id: return "duplicate_id";
    case Refusal::unknown_id: return "unknown_id";
    case Refusal::not_finite: return "not_finite";
    case Refusal::invalid_factor: return "invalid_factor";
    case Refusal::opposed_planes: return "opposed_planes";
  }
  return "?";
}

}  // namespace sgraph
