#include "sgraph_slam/core/pipeline/run_folder.hpp"

#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/io/map_folder.hpp"
#include "sgraph_slam/core/params/params_io.hpp"

namespace sgraph {

RunReport write_run(const std::string& folder, const Pipeline& pipeline, const Params& params, const RunInfo& info) {
  make_folder(folder);
  const std::string base = folder + '/';
  Params described = params;
  write_file(base + "params.yaml", to_yaml([&described](ParamVisitor& v) { described.describe(v); }));
  write_file(base + "timings.csv", timings_csv(pipeline.records()));
  const Trajectory trajectory = pipeline.trajectory();
  if (pipeline.until() >= Stage::odometry) {
    write_file(base + "trajectory.tum", tum_text(trajectory));
    write_file(base + "trajectory_live.tum", tum_text(pipeline.live_trajectory()));
    write_file(base + "keyframes.tum", tum_text(pipeline.odometry_keyframes()));
  }
  if (pipeline.until() >= Stage::mapping) write_map(folder, *pipeline.snapshot(), trajectory, pipeline.T_base_lidar(), params.output);
  RunReport report = make_report(pipeline, info);
  write_file(base + "report.json", report_json(report));
  return report;
}

}  // namespace sgraph
