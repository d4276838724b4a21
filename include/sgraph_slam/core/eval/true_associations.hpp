#pragma once

#include <optional>

#include "sgraph_slam/core/eval/association_error.hpp"

namespace sgraph {

/// What the associations cost: the keyframes' error as mapped, and with the truth's associations in place of the mapping's.
struct TrueAssociations {
  Trajectory mapped;     ///< keyframes, map frame
  Trajectory corrected;  ///< the same, optimised with every observation of a wall given to the face that it is of
};

/// Optimises the graph that `snapshot` holds once more. Observations of walls go to the true faces (all in one plane are one), as `true_lines` finds
/// them; those of floors, furniture and what lies on no face stay as they are. Rooms and corridors are left out in both.
/// Nothing when the snapshot's factors make no graph.
std::optional<TrueAssociations> with_true_associations(const GraphSnapshot& snapshot, const Trajectory& truth, const Pose& T_truth_map,
                                                       const std::vector<WallFace>& faces, const WallScore& walls);

}  // namespace sgraph
