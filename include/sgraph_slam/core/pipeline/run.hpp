#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/localisation/mapping_session.hpp"
#include "sgraph_slam/core/pipeline/front_end.hpp"

namespace sgraph {

/// The solves of a map that is seen again and again.
class SolveHistory {
 public:
  /// Takes the newest solve of a state, unless the state was noted before: one that is handed out again carries the same solve again.
  void note(const GraphSnapshot& state) {
    if (state.version != noted_ && state.last_solve.keyframes > 0) solves_.push_back(state.last_solve);
    noted_ = state.version;
  }
  [[nodiscard]] const std::vector<SolveSummary>& solves() const { return solves_; }

 private:
  std::vector<SolveSummary> solves_;
  std::int64_t noted_ = 0;  // version of the newest state noted
};

/// A recording being mapped: the mapping stage, fed with what the stages before it made, and all that a run folder tells.
class Run {
 public:
  /// Maps only when `until` is the mapping. `start`: the map to take up, if any.
  Run(const MappingParams& params, const Pose& T_base_lidar, Stage until, SessionStart start = {});

  /// Shows the map to an observer as it grows (see BackEnd).
  void observe(MapObserver* observer) { session_.observe(observer); }

  /// Takes what was made of the next scan. The record stays valid until the next call.
  const ScanRecord& take(const MeasuredScan& scan);
  /// Takes what was left at the recording's end and optimises once more.
  void finish(const MeasuredScan& rest);

  [[nodiscard]] Stage until() const { return until_; }
  [[nodiscard]] const Pose& T_base_lidar() const { return T_base_lidar_; }
  [[nodiscard]] const std::vector<ScanRecord>& records() const { return records_; }
  /// What the end of the recording took.
  [[nodiscard]] const StageCost& finish_cost() const { return finish_cost_; }
  /// All stages over the whole run, also where several runs share one.
  [[nodiscard]] StageCost total_cost() const;
  /// Base poses in the map as known when each scan had been processed.
  [[nodiscard]] const Trajectory& live_trajectory() const { return live_; }
  /// Base poses in odom, final (one scan late).
  [[nodiscard]] const Trajectory& odometry_trajectory() const { return finals_; }
  /// Keyframe poses in odom.
  [[nodiscard]] const Trajectory& odometry_keyframes() const { return keyframes_; }
  /// Base poses in the map of every scan, with what is known now. Before mapping, or without it, the odometry's final poses.
  [[nodiscard]] Trajectory trajectory() const;
  [[nodiscard]] GraphSnapshotPtr snapshot() const { return session_.snapshot(); }
  /// What is known of the robot's place in the map that the run takes up; nothing when it takes up none.
  [[nodiscard]] std::optional<Localisation> localisation() const { return session_.localisation(); }
  /// All graph solves in order.
  [[nodiscard]] const std::vector<SolveSummary>& solves() const { return solves_.solves(); }
  /// CPU time of the mapping's steps [ms], each with one number a keyframe in which it was due; the recording's end is not among them.
  [[nodiscard]] const std::map<std::string, std::vector<double>>& steps() const { return steps_; }

 private:
  void map(const MeasuredScan& scan, StageCost& cost);
  void note_steps();

  Stage until_;
  Pose T_base_lidar_;
  MappingSession session_;
  std::vector<ScanRecord> records_;
  StageCost finish_cost_;
  Trajectory live_;
  Trajectory finals_;
  Trajectory keyframes_;
  SolveHistory solves_;
  std::map<std::string, std::vector<double>> steps_;
};

/// Base poses in the map of every scan that the snapshot's keyframes hold: the odometry's final poses, moved by the correction of the keyframes
/// around each, blended by time so that the trajectory has no steps. A keyframe's own scan is exactly where the keyframe is.
Trajectory corrected_trajectory(const GraphSnapshot& snapshot);

}  // namespace sgraph
