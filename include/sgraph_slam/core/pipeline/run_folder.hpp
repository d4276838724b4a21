#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sgraph_slam/core/pipeline/run.hpp"
#include "sgraph_slam/core/sensor/description.hpp"
#include "sgraph_slam/core/sensor/ring_calibration.hpp"
#include "sgraph_slam/core/store/map_recording.hpp"

namespace sgraph {

/// What a run's report says beyond what the run knows.
struct RunInfo {
  std::vector<std::string> sources;                    ///< recordings
  double wall_seconds = 0;                             ///< from the first scan read to the last solve
  std::optional<double> cpu_seconds;                   ///< of all that the run took; nothing: the stages' own
  std::map<std::string, int> dropped_before;           ///< scans that never reached the pipeline, by reason
  std::map<std::string, int> readings_dropped;         ///< of the robot's odometry and the inertial unit, by reason
  std::optional<SensorDescription> sensor;             ///< what was recognised of the LiDAR
  std::shared_ptr<const RingCalibration> calibration;  ///< of its beams; null or without beams: none
  std::vector<std::string> notes;                      ///< what else there is to say of the recording, a sentence each
  std::string stopped_by;                              ///< why the run ended early; empty when it didn't
  std::optional<RecordingFigures> store;               ///< the map file, where one was written
};

/// Time that a stage took, over the scans in which it ran.
struct StageFigures {
  Stage stage = Stage::prefilter;
  int runs = 0;
  double mean = 0, std = 0, p50 = 0, p99 = 0, max = 0;  ///< [ms]
};

/// CPU time that a step of the mapping took, over the keyframes in which it was due.
struct StepFigures {
  std::string step;
  int runs = 0;
  double total = 0;                   ///< [s]
  double mean = 0, p99 = 0, max = 0;  ///< [ms]
};

/// The figures of report.json.
struct RunReport {
  RunInfo info;
  int scans = 0;       ///< that reached the pipeline
  int accepted = 0;    ///< by the odometry
  int degenerate = 0;  ///< of these, scans that didn't hold every direction of motion
  std::map<std::string, int> dropped;
  int keyframes = 0;
  int planes = 0, rooms = 0, corridors = 0;
  double path_length = 0;   ///< [m]
  double data_seconds = 0;  ///< from the first scan's stamp to the last one's
  double times_real_time = 0;
  double cpu_seconds = 0;
  double peak_memory_mib = 0;
  std::map<std::string, int> odometry_status;  ///< scans by how their motion was found
  std::vector<StageFigures> stages;            ///< time on the clock
  std::vector<StageFigures> stages_cpu;        ///< CPU time
  std::vector<StepFigures> mapping_steps;      ///< by name
  StageTimes finish_milliseconds{};
  std::vector<SolveSummary> solves;
  std::optional<Localisation> localisation;  ///< where a map was to be taken up
};

/// The memory is that of the process at the moment of the call.
RunReport make_report(const Run& run, const RunInfo& info);
std::string report_json(const RunReport& report);
/// The report in short, for a terminal.
std::string report_table(const RunReport& report);
/// A row a scan.
std::string timings_csv(const std::vector<ScanRecord>& records);

/// Writes the run folder: trajectories, parameters, timings, the report, and the map's files when the run went as far as mapping. Throws
/// std::runtime_error with the file and the reason. Returns the report.
RunReport write_run(const std::string& folder, const Run& run, const Params& params, const RunInfo& info);

}  // namespace sgraph
