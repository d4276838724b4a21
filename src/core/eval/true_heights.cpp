#include "sgraph_slam/core/eval/true_heights.hpp"

#include <map>
#include <set>
#include <vector>

#include "sgraph_slam/core/eval/trajectory_error.hpp"
#include "sgraph_slam/core/types/storey.hpp"

namespace sgraph {
namespace {

// A stretch of the trajectory: from the keyframe before (left out) to this one.
struct Stretch {
  int storey;
  bool ride;
};

// A ride goes between two storeys of which one's height is unknown; keyframes between them that are on neither are part of it.
std::map<Stamp, Stretch> stretches_of(const GraphSnapshot& graph, const std::set<int>& unknown) {
  std::map<Stamp, Stretch> stretches;
  int last = 0;                   // storey, or the stairwell
  std::vector<Stretch*> between;  // since then
  for (const auto& [id, keyframe] : graph.keyframes) {
    Stretch& here = stretches[keyframe.stamp] = {keyframe.storey, false};
    if (keyframe.storey != stairwell) {
      const bool known = unknown.count(last) == 0 && unknown.count(keyframe.storey) == 0;
      const bool ride = stretches.size() > 1 && !known && (last != keyframe.storey || between.size() > 1);
      for (Stretch* stretch : between) stretch->ride = ride;
      between.clear();
      last = keyframe.storey;
    }
    between.push_back(&here);
  }
  return stretches;
}

}  // namespace

Trajectory at_true_heights(const Trajectory& estimate, const Trajectory& truth, const GraphSnapshot& graph) {
  std::set<int> unknown;
  for (const SceneStorey& storey : graph.storeys) {
    if (!storey.height_known || storey.height_sigma > 0) unknown.insert(storey.id);
  }
  if (unknown.empty() || graph.keyframes.empty()) return estimate;
  const std::map<Stamp, Stretch> stretches = stretches_of(graph, unknown);
  const auto stretch_at = [&](Stamp stamp) {
    const auto found = stretches.lower_bound(stamp);
    return found != stretches.end() ? found->second : stretches.rbegin()->second;
  };
  struct Mean {
    double sum = 0;
    int count = 0;
    [[nodiscard]] double value() const { return count > 0 ? sum / count : 0; }
  };
  std::map<int, Mean> above;  // truth above the estimate, on each storey of unknown height; -1: on all others
  const auto group = [&](const Stretch& stretch) { return unknown.count(stretch.storey) != 0 ? stretch.storey : -1; };
  for (const PosePair& pair : pair_by_stamp(estimate, truth)) {
    const Stretch stretch = stretch_at(pair.stamp);
    if (stretch.ride) continue;
    Mean& mean = above[group(stretch)];
    mean.sum += pair.truth.translation.z() - pair.estimate.translation.z();
    ++mean.count;
  }
  Trajectory moved;
  for (const StampedPose& pose : estimate) {
    const Stretch stretch = stretch_at(pose.stamp);
    if (stretch.ride) continue;
    moved.push_back(pose);
    if (group(stretch) >= 0) moved.back().pose.translation.z() += above[stretch.storey].value() - above[-1].value();
  }
  return moved;
}

}  // namespace sgraph
