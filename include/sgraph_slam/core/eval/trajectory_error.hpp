#pragma once

#include <vector>

#include "sgraph_slam/core/types/pose.hpp"
#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {

/// An estimated and a true pose of the same moment, each in its own frame.
struct PosePair {
  Stamp stamp;  ///< of the estimate
  Pose estimate;
  Pose truth;
};

/// Pairs each pose of the shorter trajectory with the nearest in time of the longer one; those further apart than `max_difference` [s] are left out.
/// In order of stamp. The rule of evo (github.com/MichaelGrupp/evo), so that figures can be compared.
std::vector<PosePair> pair_by_stamp(const Trajectory& estimate, const Trajectory& truth, double max_difference = 0.01);

/// The rigid motion `T_truth_estimate` (no scale) that brings the estimated positions closest to the true ones in the sense of least squares
/// (Umeyama, PAMI 1991). Where the positions lie on a line or a point, the orientations settle what they leave open.
/// Throws std::runtime_error without pairs.
Pose align(const std::vector<PosePair>& pairs);

/// Error of one pose after alignment.
struct PoseError {
  double translation = 0;  ///< [m]
  double rotation = 0;     ///< angle [rad]
};

struct PoseErrorStatistics {
  Statistics translation;   ///< [m]
  Statistics rotation_deg;  ///< [deg]
};

PoseErrorStatistics statistics_of(const std::vector<PoseError>& errors);

/// Absolute trajectory error, one a pair: distance of the aligned position from the true one, angle between the orientations.
std::vector<PoseError> absolute_errors(const std::vector<PosePair>& pairs, const Pose& T_truth_estimate);

/// Relative pose error over consecutive stretches of `length` [m] measured along the *estimate*, the first beginning after the first `length`, as evo
/// takes them (`--delta 10 --delta_unit m`). Needs no alignment.
std::vector<PoseError> relative_errors(const std::vector<PosePair>& pairs, double length = 10);

/// Mean drift over all stretches of `length` [m] measured along the truth, one begun every second, as the KITTI odometry benchmark takes them.
struct Drift {
  int segments = 0;
  double translation_percent = 0;
  double rotation_deg_per_m = 0;
};

Drift drift(const std::vector<PosePair>& pairs, double length = 10);

/// Error of the last pose as seen from the first. Needs no alignment; for a closed round it is the error of the return.
PoseError start_to_end_error(const std::vector<PosePair>& pairs);

/// Length of the true path [m].
double path_length(const std::vector<PosePair>& pairs);

}  // namespace sgraph
