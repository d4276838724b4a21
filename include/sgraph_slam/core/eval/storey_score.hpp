#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// On which storey the robot truly is from when to when.
struct StoreyStretch {
  double begin = 0;           ///< [s] from the start
  double end = 0;             ///< [s]
  std::optional<int> storey;  ///< none: on stairs or a ramp
};

struct TrueStoreys {
  std::vector<double> elevations;  ///< of the floors [m], by number
  std::vector<StoreyStretch> path;
};

/// From truth.json; nothing when it has no storeys or doesn't say where the robot was. Throws std::runtime_error.
std::optional<TrueStoreys> read_true_storeys(const std::string& truth_json);

/// How well storeys were told apart.
struct StoreyScore {
  int truths = 0;                     ///< that the robot was on
  int estimates = 0;                  ///< with keyframes
  int keyframes = 0;                  ///< taken on a storey, not on stairs
  int right = 0;                      ///< of them on the right one
  int on_stairs = 0;                  ///< taken on stairs
  int stairs_misplaced = 0;           ///< of them said to be on a storey whose floor is over half a metre away
  std::vector<double> height_errors;  ///< of each true storey's floor against the first one's, where found and known [m]
  int heights_unknown = 0;            ///< storeys of which the map says that their height isn't known
  int planes_across = 0;              ///< planes of a storey, not of the stairwell, that keyframes of two storeys took for one
};

/// `start`: stamp of the truth's first moment; `T_truth_map` aligns the map.
StoreyScore score_storeys(const GraphSnapshot& graph, const TrueStoreys& truth, Stamp start, const Pose& T_truth_map);

}  // namespace sgraph
