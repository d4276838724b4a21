// Maps a simulated world as it is simulated, without writing a bag, and writes a run folder as run_bag does; several with --variant.
#include <tbb/global_control.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/io/tum.hpp"
#include "sgraph_slam/core/params/params_io.hpp"
#include "sgraph_slam/core/pipeline/batches.hpp"
#include "sgraph_slam/core/pipeline/run_folder.hpp"
#include "sgraph_slam/core/pipeline/variants.hpp"
#include "sgraph_slam/core/store/map_recording.hpp"
#include "sgraph_slam/core/util/progress.hpp"
#include "sgraph_slam/core/util/resources.hpp"
#include "sgraph_slam/core/util/stopwatch.hpp"
#include "shared/simulation_options.hpp"

namespace sgraph {
namespace {

struct Options {
  SimulationOptions simulation;
  std::string out;
  std::vector<std::string> configs;
  std::vector<std::string> assignments;
  std::vector<std::string> variants;
  std::string odometry;
  std::string until = "mapping";
  bool imu = false;
  int threads = 0;
  bool quiet = false;
};

void declare_options(CLI::App& app, Options& options) {
  declare(app, options.simulation);
  app.add_option("--out", options.out,
                 "Run folder to write, or with --variant the folder for a run folder each; gets ground_truth.tum and truth.json too")
      ->required();
  app.add_option("--config", options.configs, "YAML file over the defaults; later ones win")->allow_extra_args(false);
  app.add_option("--set", options.assignments, "NAME=VALUE: one parameter, over the files")->allow_extra_args(false);
  app.add_option("--variant", options.variants,
                 "NAME or NAME:key=value,key=value: a further way to map the same scans; keys are parameters, until, encoders, imu. Into OUT/NAME")
      ->allow_extra_args(false);
  app.add_option("--odometry", options.odometry, "vgicp: from the LiDAR; topic: the robot's encoders")->check(CLI::IsMember({"vgicp", "topic"}));
  app.add_flag("--imu", options.imu, "Give the odometry the inertial unit's readings");
  app.add_option("--until", options.until, "Last stage to run")
      ->capture_default_str()
      ->check(CLI::IsMember({"prefilter", "odometry", "segmentation", "mapping"}));
  app.add_option("--threads", options.threads, "Most threads to use; 0: all")->check(CLI::NonNegativeNumber);
  app.add_flag("--quiet", options.quiet, "Print errors only");
}

std::vector<Variant> read_variants(const Options& options) {
  ParamValues values;
  for (const std::string& path : options.configs) {
    for (const auto& [name, value] : read_yaml_values(path)) values[name] = value;
  }
  for (const std::string& assignment : options.assignments) set_value(values, assignment);
  if (!options.odometry.empty()) values["odometry.source"] = options.odometry;
  Variant base;
  base.until = *stage_from(options.until);
  base.imu = options.imu;
  std::vector<Variant> variants;
  for (const std::string& text : options.variants) variants.push_back(parse_variant(text, values, base));
  if (variants.empty()) variants.push_back(parse_variant("run", values, base));
  return variants;
}

// Returns the CPU time of the simulator [s].
double map_world(bool quiet, sim::SimulatedSource& source, VariantSet& set) {
  Progress progress(source.scan_count(), isatty(STDERR_FILENO) != 0);
  Stopwatch watch;
  double seconds = 0;
  double simulator_seconds = 0;
  const auto simulate = [&source, &simulator_seconds] {
    const double before = thread_cpu_seconds();
    auto event = source.next();
    simulator_seconds += thread_cpu_seconds() - before;
    return event;
  };
  read_ahead(simulate, [&](const SensorBatch& batch) {
    for (const SensorEvent& reading : batch.readings) {
      if (const auto* odometry = std::get_if<OdometrySample>(&reading)) set.add(*odometry);
      if (const auto* imu = std::get_if<ImuSample>(&reading)) set.add(*imu);
    }
    if (!batch.scan) return;
    set.process(*batch.scan);
    seconds += 1e-3 * watch.lap();
    const auto& records = set.runs().front().records();
    if (!quiet) std::cerr << progress.after(static_cast<int>(records.size()), records.back().stamp - records.front().stamp, seconds) << std::flush;
  });
  set.finish();
  if (!quiet) std::cerr << progress.end();
  return simulator_seconds;
}

void write_simulation(const Options& options, const sim::SimulatedSource& source, double cpu) {
  const nlohmann::ordered_json json{{"world", options.simulation.world},
                                    {"scans", source.scan_count()},
                                    {"data_seconds", source.duration()},
                                    {"cpu_seconds", cpu},
                                    {"seed", options.simulation.settings.lidar.seed},
                                    {"noise_m", options.simulation.settings.lidar.range_noise},
                                    {"sensor", options.simulation.sensor},
                                    {"unit", options.simulation.unit},
                                    {"building", options.simulation.building},
                                    {"session", options.simulation.session},
                                    {"rate_hz", options.simulation.settings.lidar.rate}};
  write_file(options.out + "/simulation.json", json.dump(1) + '\n');
}

std::string folder_of(const Options& options, const Variant& variant) {
  return options.variants.empty() ? options.out : options.out + '/' + variant.name;
}

// The map file of each variant, null for those that do not map.
std::vector<std::unique_ptr<MapRecording>> record_maps(const Options& options, const Pose& T_base_lidar, VariantSet& set) {
  std::vector<std::unique_ptr<MapRecording>> recordings;
  for (std::size_t i = 0; i < set.variants().size(); ++i) {
    const Variant& variant = set.variants()[i];
    recordings.emplace_back();
    if (variant.until != Stage::mapping) continue;
    make_folder(folder_of(options, variant));
    StoredSession session;
    session.source = options.simulation.world;
    session.T_base_lidar = T_base_lidar;
    Params params = variant.params;
    session.parameters = to_yaml([&params](ParamVisitor& v) { params.describe(v); });
    recordings.back() = std::make_unique<MapRecording>(folder_of(options, variant) + "/map.sgmap", std::move(session));
    set.observe(i, &recordings.back()->observer());
  }
  return recordings;
}

// A run's time is that of its stages: without the simulator's, and with all of those that it shared.
void write(const Options& options, VariantSet& set, const std::vector<std::unique_ptr<MapRecording>>& recordings) {
  for (std::size_t i = 0; i < set.variants().size(); ++i) {
    const Variant& variant = set.variants()[i];
    const std::string folder = folder_of(options, variant);
    const StageTimes wall = set.runs()[i].total_cost().wall;
    RunInfo info;
    info.sources = {options.simulation.world};
    info.wall_seconds = 1e-3 * std::accumulate(wall.begin(), wall.end(), 0.0);
    set.observe(i, nullptr);
    if (recordings[i]) info.store = recordings[i]->finish();
    info.calibration = set.calibration(i);
    const RunReport report = write_run(folder, set.runs()[i], variant.params, info);
    if (options.quiet) continue;
    if (!options.variants.empty()) std::cout << (i > 0 ? "\n" : "") << variant.name << ": ";
    std::cout << report_table(report) << "written to " << folder << std::endl;
  }
}

void run(Options& options) {
  std::vector<Variant> variants = read_variants(options);
  make_folder(options.out);
  const sim::World world = read_world(options.simulation);
  sim::SimulatedSource source(world, options.simulation.settings);
  write_tum(source.ground_truth(), options.out + "/ground_truth.tum");
  write_file(options.out + "/truth.json", sim::truth_json(source));
  VariantSet set(std::move(variants), source.T_base_lidar());
  const auto recordings = record_maps(options, source.T_base_lidar(), set);
  write_simulation(options, source, map_world(options.quiet, source, set));
  write(options, set, recordings);
}

}  // namespace
}  // namespace sgraph

int main(int argc, char** argv) {
  sgraph::return_freed_memory();
  sgraph::Options options;
  CLI::App app("Maps a simulated world without writing a bag: the run folder of run_bag, and the world's truth");
  sgraph::declare_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;
  }
  try {
    std::optional<tbb::global_control> limit;
    if (options.threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options.threads));
    sgraph::run(options);
    return 0;
  } catch (const sgraph::ParamError& error) {
    for (const std::string& line : error.errors()) std::cerr << "run_world: " << line << '\n';
  } catch (const std::exception& error) {
    std::cerr << "run_world: " << error.what() << '\n';
  }
  return 1;
}
