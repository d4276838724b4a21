#pragma once

#include "sgraph_slam/core/loops/params.hpp"
#include "sgraph_slam/core/types/cloud.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

enum class MatchFailure {
  none,
  empty,          ///< too few points in a cloud
  not_converged,  ///< the optimisation gave up
  fitness,        ///< matched points are too far apart
  overlap,        ///< too few points have a match
};

const char* to_string(MatchFailure value);

/// One cloud aligned to another.
struct ScanMatch {
  MatchFailure failure = MatchFailure::empty;
  Pose T_target_source;
  Matrix6 covariance =
      Matrix6::Identity();  ///< of it: rotation, translation; right perturbation. Wide along what the surfaces don't hold (a bare corridor)
  double fitness = 0;       ///< mean squared distance of the matched points [m^2]
  double overlap = 0;       ///< share of the source's points that have a match
};

/// Aligns with the normal distributions transform of PCL (the paper's choice), from a guess, and judges the result. Deterministic; a few 100 ms.
ScanMatch match_scans(const Cloud& target, const Cloud& source, const Pose& guess_T_target_source, const LoopParams& params);

}  // namespace sgraph
