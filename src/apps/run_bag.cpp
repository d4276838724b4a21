// Maps a recording as fast as the machine can, without a ROS master, and writes a run folder.
#include <tbb/global_control.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <stdexcept>

#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/params/params_io.hpp"
#include "sgraph_slam/core/pipeline/pipeline.hpp"
#include "sgraph_slam/core/pipeline/run_folder.hpp"
#include "sgraph_slam/core/store/map_recording.hpp"
#include "sgraph_slam/core/util/progress.hpp"
#include "sgraph_slam/core/util/resources.hpp"
#include "sgraph_slam/core/util/stopwatch.hpp"
#include "sgraph_slam/ros/bag_source.hpp"
#include "sgraph_slam/ros/settings.hpp"

namespace sgraph {
namespace {

std::atomic<bool> interrupted{false};

struct Options {
  BagOptions bag;
  std::string out;
  std::vector<std::string> configs;
  std::vector<std::string> assignments;
  std::string odometry;
  std::string base_frame;
  std::string base_to_lidar;
  std::string lidar_frame;
  std::string calibration;
  std::string odom_topic;
  std::string until = "mapping";
  std::string store;
  std::string map;
  std::string map_mode = "continue";
  std::string start_pose;
  std::vector<std::string> start;
  double duration = 0;
  int threads = 0;
  bool quiet = false;
};

void declare(CLI::App& app, Options& options) {
  app.add_option("BAG", options.bag.bags, "Recordings; several are merged by time")->required();
  app.add_option("--out", options.out, "Run folder to write")->required();
  app.add_option("--config", options.configs, "YAML file over the defaults; later ones win")->take_all();
  app.add_option("--set", options.assignments, "NAME=VALUE: one parameter, over the files")->take_all();
  app.add_option("--points-topic", options.bag.points_topic,
                 "Clouds (sensor_msgs/PointCloud2) or packets (velodyne_msgs/VelodyneScan); needed when there are several");
  app.add_option("--odom-topic", options.odom_topic, "Robot's odometry (nav_msgs/Odometry); /odom with --odometry topic, else none");
  app.add_option("--imu-topic", options.bag.imu_topic, "Inertial unit (sensor_msgs/Imu); none unless given");
  app.add_option("--odometry", options.odometry, "vgicp: from the LiDAR; topic: the robot's own")->check(CLI::IsMember({"vgicp", "topic"}));
  app.add_option("--base-frame", options.base_frame, "Robot's frame (base_link)");
  app.add_option("--base-to-lidar", options.base_to_lidar, "\"X Y Z YAW PITCH ROLL\" of the LiDAR on the robot, in place of /tf_static");
  app.add_option("--calibration", options.calibration, "calibration.yaml of an earlier run, to begin with");
  app.add_option("--lidar-frame", options.lidar_frame, "The LiDAR's frame, where several LiDARs share the topic or clouds name none");
  app.add_option("--until", options.until, "Last stage to run")
      ->capture_default_str()
      ->check(CLI::IsMember({"prefilter", "odometry", "segmentation", "mapping"}));
  app.add_option("--store", options.store, "Map file to write (OUT/map.sgmap)");
  app.add_option("--map", options.map, "Map file to take up (docs/maps.md)")->check(CLI::ExistingFile);
  app.add_option("--map-mode", options.map_mode, "continue: a further session in it; localize: it stays as it is")
      ->capture_default_str()
      ->check(CLI::IsMember({"continue", "localize"}));
  app.add_option("--start-pose", options.start_pose, "\"X Y Z YAW\": where in the map the recording starts, to within some metres");
  app.add_option(
         "--start", options.start,
         "Seconds to leave out at the beginning; or where the recording starts in the map: search (default), or first: where the map does. Both "
         "may be given")
      ->expected(1)
      ->take_all();
  app.add_option("--duration", options.duration, "Seconds to read")->check(CLI::PositiveNumber);
  app.add_option("--threads", options.threads, "Most threads to use; 0: all")->check(CLI::NonNegativeNumber);
  app.add_flag("--quiet", options.quiet, "Print errors only");
  app.get_option("--config")->allow_extra_args(false);
  app.get_option("--set")->allow_extra_args(false);
}

Settings read_settings(const Options& options) {
  ParamValues values;
  for (const std::string& path : options.configs) {
    for (const auto& [name, value] : read_yaml_values(path)) values[name] = value;
  }
  for (const std::string& assignment : options.assignments) set_value(values, assignment);
  if (!options.odometry.empty()) values["odometry.source"] = options.odometry;
  if (!options.calibration.empty()) values["odometry.calibration.file"] = options.calibration;
  Settings settings;
  apply_values(values, [&settings](ParamVisitor& v) {
    settings.params.describe(v);
    v.group("ros", settings.ros, "What the nodelets need beside; frames and mount count here too.");
  });
  if (!options.base_frame.empty()) settings.ros.base_frame = options.base_frame;
  if (!options.lidar_frame.empty()) settings.ros.lidar_frame = options.lidar_frame;
  if (!options.base_to_lidar.empty()) settings.ros.base_to_lidar = options.base_to_lidar;
  return settings;
}

// The two meanings of --start.
std::string start_place(const Options& options, BagOptions* bag) {
  std::string place = "search";
  for (const std::string& word : options.start) {
    if (word == "first" || word == "search") {
      place = word;
      continue;
    }
    std::size_t read = 0;
    try {
      const double seconds = std::stod(word, &read);
      if (read == word.size() && seconds >= 0) {
        if (bag != nullptr) bag->start = seconds;
        continue;
      }
    } catch (const std::logic_error&) {
    }
    throw std::runtime_error("--start: '" + word + "' is neither a number of seconds, nor first, nor search");
  }
  return place;
}

BagOptions bag_options(const Options& options, const Settings& settings) {
  BagOptions bag = options.bag;
  start_place(options, &bag);
  bag.odom_topic = options.odom_topic.empty() && settings.params.odometry.source == "topic" ? "/odom" : options.odom_topic;
  bag.base_frame = settings.ros.base_frame;
  bag.lidar_frame = settings.ros.lidar_frame;
  bag.sensor = settings.params.sensor;
  if (!settings.ros.base_to_lidar.empty()) bag.T_base_lidar = parse_mount(settings.ros.base_to_lidar);
  if (options.duration > 0) bag.duration = options.duration;
  return bag;
}

// Feeds the recording to the pipeline until its end, an interrupt, or damage in the file; says which in `info`.
void map_recording(BagSource& source, Pipeline& pipeline, bool quiet, RunInfo& info) {
  Progress progress(source.scan_count(), isatty(STDERR_FILENO) != 0);
  Stopwatch watch;
  double seconds = 0;
  try {
    const auto next = [&source]() -> std::optional<SensorEvent> {
      if (interrupted) return std::nullopt;
      return source.next();
    };
    pipeline.process_all(next, [&](const ScanRecord& newest) {
      seconds += 1e-3 * watch.lap();
      const auto& records = pipeline.run().records();
      if (!quiet) std::cerr << progress.after(static_cast<int>(records.size()), newest.stamp - records.front().stamp, seconds) << std::flush;
    });
    if (interrupted) info.stopped_by = "interrupt";
  } catch (const std::runtime_error& error) {  // what was read so far is still worth its map
    info.stopped_by = error.what();
  }
  pipeline.finish();
  info.wall_seconds = seconds + 1e-3 * watch.lap();
  info.cpu_seconds = cpu_seconds();
  if (!quiet) std::cerr << progress.end();
  for (const auto& [fault, count] : source.dropped()) info.dropped_before[to_string(fault)] += count;
  info.readings_dropped = source.readings_dropped();
  info.notes = source.notes();
  info.calibration = pipeline.calibration();
}

void refuse_if_nothing_was_mapped(const Pipeline& pipeline, const RunInfo& info) {
  if (pipeline.run().until() == Stage::prefilter || !pipeline.run().live_trajectory().empty()) return;
  const RunReport report = make_report(pipeline.run(), info);
  std::string reasons;
  for (const auto& [reason, count] : report.dropped) reasons += (reasons.empty() ? "" : ", ") + reason + ' ' + std::to_string(count);
  throw std::runtime_error("not one scan could be used (" + (reasons.empty() ? "none was read" : reasons) + ")");
}

StoredSession session_of(const Options& options, const Settings& settings, const BagSource& source) {
  StoredSession session;
  for (const std::string& bag : options.bag.bags) session.source += (session.source.empty() ? "" : " ") + bag;
  session.T_base_lidar = source.T_base_lidar();
  Params params = settings.params;
  session.parameters = to_yaml([&params](ParamVisitor& v) { params.describe(v); });
  return session;
}

SessionStart start_of(const Options& options) {
  SessionStart start;
  const std::string place = start_place(options, nullptr);
  if (options.map.empty()) {
    if (!options.start_pose.empty() || place == "first") throw std::runtime_error("a start in the map needs --map");
    return start;
  }
  return make_start(options.map, options.map_mode, options.start_pose.empty() ? place : options.start_pose);
}

void run(const Options& options) {
  const Settings settings = read_settings(options);
  BagSource source(bag_options(options, settings));
  make_folder(options.out);  // before the work, not after it
  const SessionStart start = start_of(options);
  Pipeline pipeline(settings.params, source.T_base_lidar(), *stage_from(options.until), start);
  RunInfo info;
  info.sources = options.bag.bags;
  std::optional<MapRecording> recording;
  if (pipeline.run().until() == Stage::mapping && !(start.map && start.mode == MapMode::localize)) {
    const std::string path = options.store.empty() ? options.out + "/map.sgmap" : options.store;
    if (start.map) {
      recording.emplace(path, session_of(options, settings, source), start.map->path, start.map->stored);
    } else {
      recording.emplace(path, session_of(options, settings, source));
    }
    pipeline.observe(&recording->observer());
  }
  info.sensor = source.sensor();
  if (!options.quiet) std::cerr << source.points_topic() << ": " << source.sensor().text() << std::endl;
  map_recording(source, pipeline, options.quiet, info);
  const bool damaged = !info.stopped_by.empty() && !interrupted;
  if (damaged && pipeline.run().live_trajectory().empty()) throw std::runtime_error(info.stopped_by);
  refuse_if_nothing_was_mapped(pipeline, info);
  std::string store_problem;
  if (recording) {
    pipeline.observe(nullptr);
    try {
      info.store = recording->finish();
    } catch (const StoreError& error) {  // the other files are still worth writing
      store_problem = error.what();
    }
  }
  const RunReport report = write_run(options.out, pipeline.run(), settings.params, info);
  if (!options.quiet) {
    for (const std::string& note : info.notes) std::cerr << "note: " << note << '\n';
    for (const auto& [what, count] : info.readings_dropped) std::cerr << "note: " << count << " readings left out: " << what << '\n';
  }
  if (!options.quiet && info.calibration && info.calibration->corrects()) std::cout << info.calibration->text() << '\n';
  if (!options.quiet) std::cout << report_table(report) << "written to " << options.out << (interrupted ? " (interrupted)" : "") << std::endl;
  if (!store_problem.empty()) throw std::runtime_error(store_problem);
  if (damaged) throw std::runtime_error(info.stopped_by + "; what came before is in " + options.out);
}

// A mount may also be given as six numbers; CLI11 would take the negative ones for options.
std::vector<std::string> arguments(int argc, char** argv) {
  const auto is_number = [](const std::string& word) { return !word.empty() && word.find_first_not_of("0123456789+-.eE") == std::string::npos; };
  std::vector<std::string> words;
  for (int i = 1; i < argc; ++i) {
    words.emplace_back(argv[i]);
    if (words.back() != "--base-to-lidar" || i + 6 >= argc) continue;
    std::string joined;
    int taken = 0;
    for (; taken < 6 && is_number(argv[i + 1 + taken]); ++taken) joined += (taken == 0 ? "" : " ") + std::string(argv[i + 1 + taken]);
    if (taken != 6) continue;
    words.push_back(joined);
    i += taken;
  }
  return {words.rbegin(), words.rend()};  // CLI11 wants them backwards
}

int main_of_run_bag(int argc, char** argv) {
  Options options;
  CLI::App app("Maps a recording and writes a run folder: trajectories, graph, map, floor plan, report", "run_bag");
  declare(app, options);
  try {
    app.parse(arguments(argc, argv));
    std::signal(SIGINT, [](int) {
      interrupted = true;
      std::signal(SIGINT, SIG_DFL);  // a second one ends at once
    });
    std::optional<tbb::global_control> limit;
    if (options.threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(options.threads));
    run(options);
    return 0;
  } catch (const CLI::CallForHelp&) {
    std::cout << app.help();
    return 0;
  } catch (const ParamError& error) {
    for (const std::string& line : error.errors()) std::cerr << "run_bag: " << line << '\n';
  } catch (const std::exception& error) {
    std::cerr << "run_bag: " << error.what() << '\n';
  }
  return 1;
}

}  // namespace
}  // namespace sgraph

int main(int argc, char** argv) {
  sgraph::return_freed_memory();
  return sgraph::main_of_run_bag(argc, argv);
}
