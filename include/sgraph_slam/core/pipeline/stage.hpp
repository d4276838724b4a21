#pragma once

#include <array>
#include <optional>
#include <string>

#include "sgraph_slam/core/odometry/odometry.hpp"
#include "sgraph_slam/core/prefilter/prefilter.hpp"
#include "sgraph_slam/core/util/stopwatch.hpp"

namespace sgraph {

enum class Stage { prefilter, odometry, segmentation, mapping };
inline constexpr std::array<Stage, 4> all_stages{Stage::prefilter, Stage::odometry, Stage::segmentation, Stage::mapping};
const char* to_string(Stage value);
/// Nothing when the word names no stage.
std::optional<Stage> stage_from(const std::string& word);

using StageTimes = std::array<double, all_stages.size()>;  ///< [ms]; 0 where a stage didn't run

/// What the stages took: time on the clock, and CPU time of the thread that ran them.
struct StageCost {
  StageTimes wall{};
  StageTimes cpu{};

  StageCost& operator+=(const StageCost& other);
};

/// How well a scan's motion was found. Kept of every scan, so without its pose and covariance.
struct MotionQuality {
  OdometryStatus status = OdometryStatus::started;
  float inlier_share = 0;  ///< share of the keypoints that found the map
  float residual_rms = 0;  ///< of the matched keypoints along the normals [m]
  int iterations = 0;
  bool degenerate = false;  ///< along some direction
};

/// What one scan cost and brought; a row of timings.csv.
struct ScanRecord {
  Stamp stamp;
  StageCost cost;
  PrefilterCounts counts;
  ScanVerdict verdict = ScanVerdict::accepted;
  MotionQuality motion;
  int keyframes = 0;  ///< closed with this scan
  int segments = 0;   ///< planes seen in their clouds
};

/// Books the time of this thread since its construction or the last booking under a stage.
class StageClock {
 public:
  StageClock();
  void book(Stage stage, StageCost& cost);

 private:
  Stopwatch wall_;
  double cpu_;
};

}  // namespace sgraph
