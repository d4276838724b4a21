#pragma once

#include <string>
#include <vector>

#include "sgraph_slam/core/types/ids.hpp"

namespace sgraph {

/// Why the graph is as it is: one proposal, accepted or refused.
struct Decision {
  KeyframeId keyframe;  ///< newest at the time
  bool accepted = false;
  std::string what;    ///< "room/3", "merge plane/7 into plane/2"
  std::string reason;  ///< in words, with the figures that decided
};

using DecisionLog = std::vector<Decision>;

}  // namespace sgraph
