#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
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

/// The true faces that lie in one plane count as one.
struct FaceLines {
  std::vector<Plane> planes;         ///< truth frame
  std::vector<std::size_t> of_face;  ///< index of the plane that holds each face
};
FaceLines face_lines(const std::vector<WallFace>& faces);

/// How many observations of walls went to the right plane.
struct AssociationScore {
  int observations = 0;  ///< of planes that lie on a face
  int wrong_face = 0;    ///< of another face than most of that plane's observations
  int split = 0;         ///< of a plane that is a duplicate: they belong to the other one

  [[nodiscard]] double right_share() const { return observations == 0 ? 1 : 1 - static_cast<double>(wrong_face + split) / observations; }
};

/// The observations of the graph that `snapshot` holds (factors in the tangent form; the points form keeps no measured plane).
std::vector<AssociatedPlane> associated_planes(const GraphSnapshot& snapshot);

/// What each observation is truly of: the index of a line, nothing when it is of no wall or of a plane that lies on no face. It is put where it was
/// truly made, `truth` at its keyframe's stamp, and is of the line that is nearest to it where it lies nearest to the keyframe on the mapped plane.
/// `T_truth_map` aligns the map.
std::vector<std::optional<std::size_t>> true_lines(const std::vector<AssociatedPlane>& observations, const std::vector<ScenePlane>& planes,
                                                   const Trajectory& truth, const Pose& T_truth_map, const FaceLines& lines, const WallScore& walls);

/// An observation is right when it and most observations of its plane are of one line, and its plane is no duplicate.
AssociationScore score_associations(const std::vector<AssociatedPlane>& observations, const std::vector<ScenePlane>& planes, const Trajectory& truth,
                                    const Pose& T_truth_map, const std::vector<WallFace>& faces, const WallScore& walls);

}  // namespace sgraph
