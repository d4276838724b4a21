// evaluate RUN_DIR --truth DIR: measures a run folder against the truth of its recording; prints a table, writes evaluation.json, evaluation.csv
// (errors over time) and evaluation.png.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <stdexcept>

#include <sys/wait.h>
#include <unistd.h>

#include "sgraph_slam/core/eval/evaluation.hpp"
#include "sgraph_slam/core/eval/true_associations.hpp"
#include "sgraph_slam/core/eval/true_heights.hpp"
#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/io/graph_json.hpp"
#include "sgraph_slam/core/io/pcd.hpp"
#include "sgraph_slam/core/io/tum.hpp"

namespace {

namespace fs = std::filesystem;
using namespace sgraph;

struct Options {
  fs::path run;
  fs::path truth;
  double map_cap = 0.5;
  double wall_range = 6;
  bool picture = true;
  bool true_associations = false;
};

// Whether the run has the file; says so when not.
bool has(const fs::path& file, const char* what_it_gives, Evaluation& evaluation) {
  if (fs::exists(file)) return true;
  evaluation.remarks.push_back(file.filename().string() + " is missing in " + file.parent_path().string() + ": " + what_it_gives + " not measured");
  return false;
}

GraphSnapshot read_graph(const fs::path& file) {
  try {
    return parse_graph_json(read_file(file));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

void measure_trajectories(const Options& options, const Trajectory& truth, Evaluation& evaluation) {
  GraphSnapshot graph;
  if (fs::exists(options.run / "graph.json")) graph = read_graph(options.run / "graph.json");
  const auto unknown = std::count_if(graph.storeys.begin(), graph.storeys.end(), [](const SceneStorey& storey) { return !storey.height_known; });
  if (unknown > 0) {
    evaluation.remarks.push_back(
        "the height of " + std::to_string(unknown) +
        " of the map's storeys is unknown: poses there are compared at their true height, those in a lift that goes are not");
  }
  const fs::path final_file = options.run / "trajectory.tum";
  if (has(final_file, "final poses, and all that needs their alignment,", evaluation))
    evaluation.final_poses = evaluate_trajectory(at_true_heights(read_tum(final_file), truth, graph), truth);
  const fs::path live_file = options.run / "trajectory_live.tum";
  if (has(live_file, "live poses", evaluation))
    evaluation.live_poses = evaluate_trajectory(at_true_heights(read_tum(live_file), truth, graph), truth);
}

template <class Key, class Value>
std::vector<Value> values_of(const std::map<Key, Value>& map) {
  std::vector<Value> values;
  for (const auto& [key, value] : map) values.push_back(value);
  return values;
}

// Everything that is compared after the alignment of the final poses.
void measure_map(const Options& options, const Trajectory& truth, Evaluation& evaluation) {
  const fs::path plan_file = options.truth / "truth.json";
  if (!evaluation.final_poses || !has(plan_file, "map, walls, rooms and corridors", evaluation)) return;
  const Plan plan = read_plan(plan_file);
  const Pose& T_truth_map = evaluation.final_poses->T_truth_estimate;
  if (has(options.run / "map.pcd", "map", evaluation)) {
    evaluation.map = map_error(read_pcd_positions(options.run / "map.pcd"), T_truth_map, plan, options.map_cap);
  }
  if (!has(options.run / "graph.json", "walls, rooms and corridors", evaluation)) return;
  const GraphSnapshot graph = read_graph(options.run / "graph.json");
  std::vector<Pose> true_poses;
  for (const StampedPose& s : truth) true_poses.push_back(s.pose);
  evaluation.faces = wall_faces(plan, true_poses, options.wall_range);
  std::vector<PlanBlock> blocks = panes(plan);
  blocks.insert(blocks.end(), plan.blocks.begin(), plan.blocks.end());
  evaluation.walls = score_walls(values_of(graph.planes), T_truth_map, evaluation.faces, blocks);
  evaluation.associations =
      score_associations(associated_planes(graph), values_of(graph.planes), truth, T_truth_map, evaluation.faces, *evaluation.walls);
  if (options.true_associations) {
    const auto study = with_true_associations(graph, truth, T_truth_map, evaluation.faces, *evaluation.walls);
    if (study) {
      evaluation.association_loss = AssociationLoss{evaluate_trajectory(study->mapped, truth).absolute.translation.rmse,
                                                    evaluate_trajectory(study->corrected, truth).absolute.translation.rmse};
    } else {
      evaluation.remarks.push_back("the graph could not be optimised with the truth's associations");
    }
  }
  evaluation.rooms = score_rooms(values_of(graph.rooms), T_truth_map, plan.rooms);
  evaluation.corridors = score_corridors(values_of(graph.corridors), T_truth_map, plan.corridors);
  const MappedPlaces mapped = read_mapped_places(options.run / "graph.json");
  const TruePlaces places = read_true_places(plan_file);
  evaluation.places = score_places(mapped.places, places.places, T_truth_map);
  const auto storeys = read_true_storeys(read_file(plan_file));
  if (storeys && storeys->elevations.size() > 1 && !truth.empty())
    evaluation.storeys = score_storeys(graph, *storeys, truth.front().stamp, T_truth_map);
  if (mapped.has_doors && places.has_doors) evaluation.doors = score_doors(mapped.doors, places.doors, T_truth_map);
}

// A row a pose pair: the aligned estimate and its error.
std::string error_rows(const TrajectoryEvaluation& e) {
  std::string text = "stamp,x,y,z,translation_m,rotation_deg\n";
  char line[200];
  for (std::size_t i = 0; i < e.pose_pairs.size(); ++i) {
    const PosePair& pair = e.pose_pairs[i];
    const Eigen::Vector3d p = e.T_truth_estimate * pair.estimate.translation;
    std::snprintf(line, sizeof line, "%lld.%09lld,%.6f,%.6f,%.6f,%.6f,%.6f\n", static_cast<long long>(pair.stamp.nanoseconds / 1'000'000'000),
                  static_cast<long long>(pair.stamp.nanoseconds % 1'000'000'000), p.x(), p.y(), p.z(), e.errors[i].translation,
                  e.errors[i].rotation * 180 / M_PI);
    text += line;
  }
  return text;
}

// The program that draws lies beside this one, in the development as in the installed space.
bool draw(const Options& options) {
  const fs::path script = fs::canonical("/proc/self/exe").parent_path() / "plot_evaluation";
  const pid_t child = fork();
  if (child < 0) return false;
  if (child == 0) {
    execl(script.c_str(), script.c_str(), options.run.c_str(), options.truth.c_str(), static_cast<char*>(nullptr));
    std::perror(script.c_str());
    _exit(127);
  }
  int status = 0;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

void run(const Options& options) {
  Evaluation evaluation;
  evaluation.run = options.run.string();
  evaluation.truth = options.truth.string();
  evaluation.map_cap = options.map_cap;
  const Trajectory truth = read_tum(options.truth / "ground_truth.tum");
  measure_trajectories(options, truth, evaluation);
  measure_map(options, truth, evaluation);
  if (!evaluation.final_poses && !evaluation.live_poses)
    throw std::runtime_error(options.run.string() + " holds neither trajectory.tum nor trajectory_live.tum");

  std::cout << to_table(evaluation);
  write_file(options.run / "evaluation.json", to_json(evaluation));
  const auto& shown = evaluation.final_poses ? *evaluation.final_poses : *evaluation.live_poses;
  write_file(options.run / "evaluation.csv", error_rows(shown));
  std::cout << "written: " << (options.run / "evaluation.json").string();
  if (options.picture && draw(options)) std::cout << ", " << (options.run / "evaluation.png").string();
  std::cout << std::endl;
}

void declare(CLI::App& app, Options& options) {
  app.add_option("run", options.run, "run folder")->required()->check(CLI::ExistingDirectory);
  app.add_option("--truth", options.truth, "folder with ground_truth.tum and, for map and rooms, truth.json")
      ->required()
      ->check(CLI::ExistingDirectory);
  app.add_option("--map-cap", options.map_cap, "map points further from every true surface are left out [m]")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_option("--wall-range", options.wall_range, "a wall counts as seen within this distance of the path [m]")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  app.add_flag("--true-associations", options.true_associations,
               "optimise the graph once more with the truth's associations of walls, and say what the mapping's cost");
  app.add_flag("!--no-picture", options.picture, "don't draw evaluation.png");
}

}  // namespace

int main(int argc, char** argv) {
  try {
    Options options;
    CLI::App app("Measures a run folder against the ground truth of its recording");
    declare(app, options);
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return app.exit(error) == 0 ? 0 : 1;
    }
    run(options);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "evaluate: %s\n", error.what());
    return 1;
  }
}
