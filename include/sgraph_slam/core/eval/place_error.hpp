#pragma once

#include <string>
#include <vector>

#include "sgraph_slam/core/eval/plan.hpp"
#include "sgraph_slam/core/types/pose.hpp"
#include "sgraph_slam/core/types/scene.hpp"
#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {

/// A place that was found where one is.
struct PlaceMatch {
  std::string truth;           ///< name of the true place
  std::int64_t estimate = -1;  ///< id of the found one
  double overlap = 0;          ///< rooms: area of intersection over union; corridors: share of the true length that the found one covers
  double center_error = 0;     ///< rooms: distance of the centres; corridors: across, since the place along is derived [m]
  double width_error = 0;      ///< rooms: the larger of the two; corridors: across [m]
  double yaw_error = 0;        ///< between the walls' directions [rad]
};

struct PlaceScore {
  int truths = 0;
  int estimates = 0;
  std::vector<PlaceMatch> matches;         ///< one a true place at most
  std::vector<std::string> missed;         ///< true places without a match
  std::vector<std::int64_t> false_alarms;  ///< found places without a match; second finds of one place are among them
  int duplicates = 0;                      ///< of the false alarms, those that lie in a true place that already has its match

  /// Right ones among the found ones; 1 when nothing was found.
  [[nodiscard]] double precision() const { return estimates == 0 ? 1 : static_cast<double>(matches.size()) / estimates; }
  /// Found ones among the true ones; 1 when there is none.
  [[nodiscard]] double recall() const { return truths == 0 ? 1 : static_cast<double>(matches.size()) / truths; }
  [[nodiscard]] Statistics center_error() const;
  [[nodiscard]] Statistics width_error() const;
};

/// Rooms found against the true ones, both moved into the frame of the truth. A pair matches when its intersection over union is at least one half;
/// the best pairs are taken first. True places that the robot does not enter, and finds of them, count nowhere.
PlaceScore score_rooms(const std::vector<SceneRoom>& found, const Pose& T_truth_map, const std::vector<PlanPlace>& truth);

/// Corridors likewise. A pair matches when the directions agree within 15 degrees, at least half of the found one's area lies in the true one, and
/// the widths agree within a third; the longest common stretch goes first.
PlaceScore score_corridors(const std::vector<SceneCorridor>& found, const Pose& T_truth_map, const std::vector<PlanPlace>& truth);

}  // namespace sgraph
