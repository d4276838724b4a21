#pragma once

#include <iterator>
#include <map>
#include <set>

#include "sgraph_slam/core/graph/marginals_cache.hpp"
#include "sgraph_slam/core/graph/odometry_drift.hpp"
#include "sgraph_slam/core/planes/dominant_frame.hpp"
#include "sgraph_slam/core/planes/ground_path.hpp"
#include "sgraph_slam/core/planes/merging.hpp"
#include "sgraph_slam/core/planes/params.hpp"
#include "sgraph_slam/core/planes/plane_map.hpp"

namespace sgraph {

/// What the steps of the metric-semantic layer are told of.
struct PlaneLayerParams {
  FactorParams factors;
  AssociationParams association;
  SemanticsParams semantics;
  MergeParams merging;
};

/// The metric-semantic layer beside its estimates, which are the graph's. Data only; the functions of the layer's steps work on it.
struct PlaneLayer {
  PlaneLayer(const PlaneLayerParams& p, const Pose& extrinsic) : params(p), T_base_lidar(extrinsic), map(p.semantics) {}

  PlaneLayerParams params;
  Pose T_base_lidar;
  PlaneMap map;
  OdometryDrift drift;
  MarginalsCache marginals;
  DominantFrame frame;                            ///< of the building
  std::map<PlanePair, KeyframeId> tested_merges;  ///< beyond their gate, and when that was found
  std::set<PlanePair> refused_merges;             ///< merged once and undone
  KeyframeId may_retire;                          ///< the first keyframe of which it hasn't been asked yet
  std::map<KeyframeId, int> storeys;              ///< of the keyframes; those that aren't here are on the first

  std::set<KeyframeId> sessions;  ///< the first keyframe of each, when there are several: nobody walked from one to the next

  /// The first keyframe of a keyframe's session; one before all when there is but one.
  [[nodiscard]] KeyframeId session_of(KeyframeId id) const {
    const auto after = sessions.upper_bound(id);
    return after == sessions.begin() ? KeyframeId{} : *std::prev(after);
  }

  [[nodiscard]] int storey_of(KeyframeId id) const {
    const auto known = storeys.find(id);
    return known == storeys.end() ? 0 : known->second;
  }

  /// Whether a pair has been found beyond its gate within the last 40 keyframes before `now`: it isn't tried again yet.
  [[nodiscard]] bool found_apart_lately(PlanePair pair, KeyframeId now) const {
    constexpr int try_again = 40;
    const auto tested = tested_merges.find(pair);
    return tested != tested_merges.end() && now.value - tested->second.value < try_again;
  }
};

/// Takes over on which storeys the keyframes are, and puts each plane on the one from which it was seen most; the lower number when there are two.
void set_storeys(PlaneLayer& planes, std::map<KeyframeId, int> storeys);

/// The robot's path on a storey, from a keyframe on.
GroundPath path_on(const Graph& graph, const PlaneLayer& planes, int storey, KeyframeId since = {});

}  // namespace sgraph
