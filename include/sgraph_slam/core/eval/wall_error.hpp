#pragma once

#include <cstdint>
#include <vector>

#include "sgraph_slam/core/eval/wall_faces.hpp"
#include "sgraph_slam/core/types/scene.hpp"
#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {

struct WallMatch {
  std::size_t face = 0;                               ///< index in the list of faces
  std::int64_t plane = -1;                            ///< id of the plane with the longest common stretch
  std::vector<std::int64_t> more;                     ///< further planes on the same face: duplicates
  std::vector<std::int64_t> from_other_storeys = {};  ///< planes on it that belong to another storey or the stairwell, one of each: as it should be
  double normal_error = 0;                            ///< angle between the normals [rad]
  double position_error = 0;                          ///< distance of the plane from the middle of what was seen of the face [m]
};

/// Mapped planes against the faces of the true walls.
struct WallScore {
  int faces = 0;                              ///< of which more than `seen_length` was in view: those that have to be found
  std::vector<WallMatch> matches;             ///< of those faces
  std::vector<std::size_t> missed;            ///< of those faces
  int duplicates = 0;                         ///< planes beyond the first on a face that has to be found
  std::vector<std::int64_t> reversed_planes;  ///< vertical planes that lie on a face but look into the wall: their side was mistaken
  std::vector<std::int64_t> other_planes;     ///< vertical planes on no face at all: furniture, columns, reveals

  [[nodiscard]] double recall() const { return faces == 0 ? 1 : static_cast<double>(matches.size()) / faces; }
  [[nodiscard]] double duplicate_share() const { return matches.empty() ? 0 : static_cast<double>(duplicates) / static_cast<double>(matches.size()); }
  [[nodiscard]] Statistics normal_error_deg() const;
  [[nodiscard]] Statistics position_error() const;
};

/// A plane lies on a face when it is vertical, its normal looks the same way within 5 degrees, it is within 0.1 m of the face in the middle of their
/// common stretch, and that is at least 0.5 m long. It lies on `blocks` (columns, furniture) instead, and on no face, when over more than half of
/// that stretch, and half of its height, it is nearer to a side of theirs that looks the same way: a cupboard's front a hand's breadth before a wall
/// is a surface of its own. `planes` are in the map's frame, faces and blocks in the truth's.
WallScore score_walls(const std::vector<ScenePlane>& planes, const Pose& T_truth_map, const std::vector<WallFace>& faces,
                      const std::vector<PlanBlock>& blocks = {}, double seen_length = 2);

}  // namespace sgraph
