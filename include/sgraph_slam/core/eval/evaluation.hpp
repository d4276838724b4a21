#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/eval/association_error.hpp"
#include "sgraph_slam/core/eval/map_error.hpp"
#include "sgraph_slam/core/eval/place_error.hpp"
#include "sgraph_slam/core/eval/place_quality.hpp"
#include "sgraph_slam/core/eval/storey_score.hpp"
#include "sgraph_slam/core/eval/trajectory_error.hpp"
#include "sgraph_slam/core/eval/wall_error.hpp"

namespace sgraph {

/// All figures of one trajectory.
struct TrajectoryEvaluation {
  int poses = 0;        ///< in the estimate
  int pairs = 0;        ///< of them with a true pose of their time
  double length = 0;    ///< of the true path between the first and last pair [m]
  double duration = 0;  ///< [s]
  Pose T_truth_estimate;
  PoseErrorStatistics absolute;  ///< ATE
  PoseErrorStatistics relative;  ///< RPE over 10 m
  Drift drift;                   ///< over 10 m
  PoseError start_to_end;
  std::vector<PosePair> pose_pairs;
  std::vector<PoseError> errors;  ///< one a pair
};

/// Throws std::runtime_error when no estimated pose has a true one of its time.
TrajectoryEvaluation evaluate_trajectory(const Trajectory& estimate, const Trajectory& truth);

/// ATE of the keyframes [m] as mapped, and with the truth's associations of walls in place of the mapping's.
struct AssociationLoss {
  double mapped = 0;
  double corrected = 0;
};

/// All figures of one run; what the run folder doesn't hold stays empty, and `remarks` says why.
struct Evaluation {
  std::string run;
  std::string truth;
  double map_cap = 0.5;  ///< [m]
  std::optional<TrajectoryEvaluation> final_poses;
  std::optional<TrajectoryEvaluation> live_poses;
  std::optional<MapError> map;
  std::optional<PlaceScore> rooms;
  std::optional<PlaceScore> corridors;
  std::optional<PlaceQuality> places;
  std::optional<DoorQuality> doors;
  std::optional<StoreyScore> storeys;  ///< of buildings with several
  std::optional<WallScore> walls;
  std::optional<AssociationScore> associations;
  std::optional<AssociationLoss> association_loss;
  std::vector<WallFace> faces;
  std::vector<std::string> remarks;
};

/// evaluation.json: every figure with its unit in the name, format 1.
std::string to_json(const Evaluation& evaluation);

/// The same as a table for people.
std::string to_table(const Evaluation& evaluation);

}  // namespace sgraph
