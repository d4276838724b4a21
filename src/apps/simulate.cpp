// Simulates a robot with a VLP-16 in a world and writes what it sees, and the truth.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "sgraph_slam/core/io/tum.hpp"
#include "sgraph_slam/core/util/progress.hpp"
#include "sgraph_slam/ros/simulated_bag.hpp"
#include "shared/simulation_options.hpp"

namespace {

using namespace sgraph;
using Clock = std::chrono::steady_clock;

struct Options {
  SimulationOptions simulation;
  std::string out;
  std::string trajectory;
  bool no_distortion = false;
  bool check = false;
  bool no_bag = false;
  bool quiet = false;
};

void write_text(const std::string& path, const std::string& text) {
  std::ofstream out(path);
  out << text << '\n';
  if (!out) throw std::runtime_error(path + ": can't be written");
}

sim::SimulatedSource make_source(const sim::World& world, Options& options) {
  sim::SimulationSettings& settings = options.simulation.settings;
  if (options.trajectory.empty()) return {world, settings};
  Trajectory recorded = read_tum(options.trajectory);
  if (!recorded.empty()) settings.lidar.start = recorded.front().stamp.nanoseconds;
  return {world, sim::Motion(std::move(recorded)), settings};
}

void run(Options& options) {
  const sim::World world = read_world(options.simulation);
  options.simulation.settings.lidar.motion_distortion = !options.no_distortion;
  sim::SimulatedSource source = make_source(world, options);
  if (!options.quiet) {
    std::fprintf(stderr, "%s: %.0f s, %.0f m at up to %.2f m/s, %d scans\n", world.name.c_str(), source.duration(), source.motion().length(),
                 source.motion().speed_limit(), source.scan_count());
  }
  if (options.check) return;
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) throw std::runtime_error(options.out + ": can't be created (" + error.message() + ")");
  write_tum(source.ground_truth(), options.out + "/ground_truth.tum");
  write_text(options.out + "/truth.json", sim::truth_json(source));
  if (options.no_bag) return;
  Progress progress(source.scan_count(), isatty(STDERR_FILENO) != 0);
  const Clock::time_point begin = Clock::now();
  write_simulated_bag(source, options.out + "/data.bag", [&](int done) {
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    if (!options.quiet) std::cerr << progress.after(done, done / options.simulation.settings.lidar.rate, seconds) << std::flush;
  });
  if (!options.quiet) std::cerr << progress.end();
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Simulates a robot with a VLP-16 in WORLD and writes data.bag, ground_truth.tum and truth.json into OUT_DIR."};
  declare(app, options.simulation);
  app.add_option("out_dir", options.out, "Folder to write into; made when it isn't there");
  app.add_option("--trajectory", options.trajectory, "Move as base_link does in this TUM file instead of along the world's route")
      ->check(CLI::ExistingFile);
  app.add_flag("--no-motion-distortion", options.no_distortion, "Each scan as seen from one pose; its points carry time 0");
  app.add_flag("--check", options.check, "Only read and check the world");
  app.add_flag("--no-bag", options.no_bag, "Only write the truth");
  app.add_flag("--quiet", options.quiet, "No progress");
  CLI11_PARSE(app, argc, argv);
  try {
    if (options.out.empty() && !options.check) throw std::runtime_error("simulate: OUT_DIR is missing");
    run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
