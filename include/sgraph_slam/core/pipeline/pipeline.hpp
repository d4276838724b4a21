#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/mapping/back_end.hpp"
#include "sgraph_slam/core/odometry/odometry.hpp"
#include "sgraph_slam/core/pipeline/params.hpp"
#include "sgraph_slam/core/prefilter/prefilter.hpp"
#include "sgraph_slam/core/segmentation/plane_segmenter.hpp"

namespace sgraph {

enum class Stage { prefilter, odometry, segmentation, mapping };
inline constexpr std::array<Stage, 4> all_stages{Stage::prefilter, Stage::odometry, Stage::segmentation, Stage::mapping};
const char* to_string(Stage value);
/// Nothing when the word names no stage.
std::optional<Stage> stage_from(const std::string& word);

using StageTimes = std::array<double, all_stages.size()>;  ///< [ms]; 0 where a stage didn't run

/// What one scan cost and brought; a row of timings.csv.
struct ScanRecord {
  Stamp stamp;
  StageTimes milliseconds{};
  PrefilterCounts counts;
  ScanVerdict verdict = ScanVerdict::accepted;
  OdometryEstimate odometry;
  int keyframes = 0;  ///< closed with this scan
  int segments = 0;   ///< planes seen in their clouds
};

/// The four stages in order on one thread: the offline program and the tests. The nodelets run the same stage objects.
class Pipeline {
 public:
  /// Runs the stages up to and including `until`. Throws what the stages' constructors throw at bad parameters.
  Pipeline(const Params& params, const Pose& T_base_lidar, Stage until = Stage::mapping);

  void add(const OdometrySample& sample) { odometry_.add(sample); }
  void add(const ImuSample& sample) { odometry_.add(sample); }

  /// Takes a raw scan in the LiDAR's frame, in order of stamp. The record stays valid until the next call.
  const ScanRecord& process(const Cloud& raw);

  /// Ends the recording: closes the last keyframe and optimises once more.
  void finish();

  [[nodiscard]] Stage until() const { return until_; }
  [[nodiscard]] const Pose& T_base_lidar() const { return T_base_lidar_; }
  [[nodiscard]] const std::vector<ScanRecord>& records() const { return records_; }
  /// What `finish` took.
  [[nodiscard]] const StageTimes& finish_milliseconds() const { return finish_milliseconds_; }
  /// Base poses in the map as known when each scan had been processed.
  [[nodiscard]] const Trajectory& live_trajectory() const { return live_; }
  /// Base poses in odom, final (one scan late).
  [[nodiscard]] const Trajectory& odometry_trajectory() const { return finals_; }
  /// Keyframe poses in odom.
  [[nodiscard]] const Trajectory& odometry_keyframes() const { return keyframes_; }
  /// Base poses in the map of every scan, with what is known now. Before mapping, or without it, the odometry's final poses.
  [[nodiscard]] Trajectory trajectory() const;
  [[nodiscard]] GraphSnapshotPtr snapshot() const { return back_end_.snapshot(); }
  /// All graph solves in order.
  [[nodiscard]] const std::vector<SolveSummary>& solves() const { return solves_; }

 private:
  // Returns how many planes were seen.
  int take(const OdometryOutput& output, StageTimes& times);
  void note_solve(const SolveSummary& solve);

  Stage until_;
  Pose T_base_lidar_;
  Prefilter prefilter_;
  Odometry odometry_;
  PlaneSegmenter segmenter_;
  BackEnd back_end_;
  std::vector<ScanRecord> records_;
  StageTimes finish_milliseconds_{};
  Trajectory live_;
  Trajectory finals_;
  Trajectory keyframes_;
  std::vector<SolveSummary> solves_;
};

/// Base poses in the map of every scan that the snapshot's keyframes hold: the odometry's final poses, moved by the correction of the keyframes
/// around each, blended by time so that the trajectory has no steps. A keyframe's own scan is exactly where the keyframe is.
Trajectory corrected_trajectory(const GraphSnapshot& snapshot);

}  // namespace sgraph
