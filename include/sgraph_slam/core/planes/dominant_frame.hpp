#pragma once

#include <vector>

#include "sgraph_slam/core/types/plane.hpp"

namespace sgraph {

/// Heading of a wall's normal [rad] and how much wall has it [m].
struct WallDirection {
  double yaw = 0;
  double length = 0;
};

/// The building's main directions: a yaw modulo 90 degrees, at first in [-45, 45) degrees and without steps from then on (design: dominant frame).
struct DominantFrame {
  double yaw = 0;     ///< [rad]
  double length = 0;  ///< of the walls along it [m]; 0: not known yet
  [[nodiscard]] bool known() const { return length > 0; }
};

/// Brings an angle into [-45, 45) degrees by quarter turns.
double wrap_quarter(double angle);

struct DominantFrameParams {
  double bin = 0.0349;       ///< width of the histogram's kernel [rad]
  double min_length = 4;     ///< walls that it takes to tell [m]
  double switch_gain = 1.3;  ///< a new direction needs this many times the length of the present one
};

/// Yaw of the building from the length-weighted histogram of its walls' directions. The present frame is refined by the walls near it and only left
/// for another that holds clearly more wall, so that classes do not flip. Returns the present frame when too little wall is known.
DominantFrame estimate_dominant_frame(const std::vector<WallDirection>& walls, const DominantFrame& present, const DominantFrameParams& params);

struct PlaneClassParams {
  double tilt = 0.2618;        ///< of a wall from the vertical, of a floor from the horizontal [rad]
  double oblique = 0.2618;     ///< of a wall's normal from the dominant axes [rad]
  double hysteresis = 0.0349;  ///< a class is left when its limit is passed by this much [rad]
};

/// x, y, horizontal or unclassified (paper, Plane Extraction; design: Planes). `present` is kept while within its limits widened by the hysteresis.
PlaneClass classify(const Eigen::Vector3d& normal_map, const DominantFrame& frame, PlaneClass present, const PlaneClassParams& params);

}  // namespace sgraph
