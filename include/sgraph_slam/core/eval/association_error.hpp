#pragma once

#include <cstdint>
#include <vector>

#include "sgraph_slam/core/eval/wall_error.hpp"
#include "sgraph_slam/core/types/plane.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// A plane as one keyframe measured it, and the mapped plane that it was taken for.
struct AssociatedPlane {
  Stamp stamp;             ///< of the keyframe
  std::int64_t plane = 0;  ///< in the map
  Plane measured;          ///< in the keyframe's base frame
};

/// How many observations of walls went to the right plane.
struct AssociationScore {
  int observations = 0;  ///< of planes that lie on a face
  int wrong_face = 0;    ///< of another face than most of that plane's observations
  int split = 0;         ///< of a plane that is a duplicate: they belong to the other one

  [[nodiscard]] double right_share() const { return observations == 0 ? 1 : 1 - static_cast<double>(wrong_face + split) / observations; }
};

/// The observations of the graph that `snapshot` holds (factors in the tangent form; the points form keeps no measured plane).
std::vector<AssociatedPlane> associated_planes(const GraphSnapshot& snapshot);

/// Each observation is put where it was truly made: `truth` at its keyframe's stamp. It is of the face line (all faces in one plane) that is nearest
/// to it where it lies nearest to the keyframe on the mapped plane. `T_truth_map` aligns the map.
AssociationScore score_associations(const std::vector<AssociatedPlane>& observations, const std::vector<ScenePlane>& planes, const Trajectory& truth,
                                    const Pose& T_truth_map, const std::vector<WallFace>& faces, const WallScore& walls);

}  // namespace sgraph
