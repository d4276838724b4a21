#include "sgraph_slam/core/pipeline/run_folder.hpp"

#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/io/map_folder.hpp"
#include "sgraph_slam/core/params/params_io.hpp"

namespace sgraph {

RunReport write_run(const std::string& folder, const Run& run, const Params& params, const RunInfo& info) {
  make_folder(folder);
  const std::string base = folder + '/';
  Params described = params;
  write_file(base + "params.yaml", to_yaml([&described](ParamVisitor& v) { described.describe(v); }));
  write_file(base + "timings.csv", timings_csv(run.records()));
  const Trajectory trajectory = run.trajectory();
  if (run.until() >= Stage::odometry) {
    write_file(base + "trajectory.tum", tum_text(trajectory));
    write_file(base + "trajectory_live.tum", tum_text(run.live_trajectory()));
    write_file(base + "keyframes.tum", tum_text(run.odometry_keyframes()));
  }
  if (run.until() >= Stage::mapping) write_map(folder, *run.snapshot(), trajectory, run.T_base_lidar(), params.output);
  if (info.calibration && !info.calibration->beams.empty()) write_file(base + "calibration.yaml", to_yaml(*info.calibration));
  RunReport report = make_report(run, info);
  write_file(base + "report.json", report_json(report));
  return report;
}

}  // namespace sgraph
