#pragma once

#include "sgraph_slam/core/graph/graph.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"
#include "sgraph_slam/core/types/decision.hpp"
#include "sgraph_slam/core/types/odometry.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// The map as the back end has it at one moment.
struct MapView {
  const Graph& graph;
  const PlaneMap& planes;
  const DecisionLog& log;                        ///< all decisions since the start
  const GraphSnapshot& snapshot;                 ///< with factors after an optimisation on demand
  const Keyframe* keyframe;                      ///< the one that was added last; null after an optimisation on demand
  const std::vector<KeyframeId>& clouds_let_go;  ///< keyframes whose clouds nobody needs any more, since the last time
};

/// Is shown the map after each keyframe and each optimisation on demand, on the back end's thread. The view is valid during the call only.
class MapObserver {
 public:
  virtual ~MapObserver() = default;
  virtual void changed(const MapView& view) = 0;
};

}  // namespace sgraph
