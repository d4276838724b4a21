#include "sgraph_slam/ros/map_services.hpp"

#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/io/map_folder.hpp"
#include "sgraph_slam/core/pipeline/pipeline.hpp"
#include "sgraph_slam/ros/map_directory.hpp"

namespace sgraph {

namespace {

constexpr std::chrono::seconds limit{60};

std::string contents(const GraphSnapshot& graph) {
  return std::to_string(graph.keyframes.size()) + " keyframes, " + std::to_string(graph.planes.size()) + " planes, " +
         std::to_string(graph.rooms.size()) + " rooms, " + std::to_string(graph.corridors.size()) + " corridors";
}

}  // namespace

MapServices::MapServices(ros::NodeHandle node, const Settings& settings, BackEndThread& back_end, MapPublisher& publisher,
                         std::function<Trajectory()> live)
    : settings_(settings),
      back_end_(back_end),
      publisher_(publisher),
      live_(std::move(live)),
      save_(node.advertiseService("save", &MapServices::save, this)),
      load_(node.advertiseService("load", &MapServices::load, this)),
      reset_(node.advertiseService("reset", &MapServices::reset, this)),
      pause_(node.advertiseService("pause", &MapServices::pause, this)),
      resume_(node.advertiseService("resume", &MapServices::resume, this)),
      optimize_(node.advertiseService("optimize", &MapServices::optimize, this)) {}

bool MapServices::save(sgraph_slam::SaveMap::Request& request, sgraph_slam::SaveMap::Response& response) {
  const auto folder = inside(settings_.ros.map_directory, request.path);
  response.success = false;
  if (!folder) {
    response.message = "'" + request.path + "' leads out of the map directory '" + settings_.ros.map_directory + "'";
    return true;
  }
  const std::optional<LiveMap> state = back_end_.optimize(limit);
  if (!state) {
    response.message = "the back end is busy: nothing saved";
    return true;
  }
  if (state->graph->keyframes.empty()) {
    response.message = "there is no map yet: nothing saved";
    return true;
  }
  try {
    const Trajectory trajectory = corrected_trajectory(*state->graph);
    write_map(folder->string(), *state->graph, trajectory, state->T_base_lidar, settings_.params.output);
    write_file((*folder / "trajectory.tum").string(), tum_text(trajectory));
    write_file((*folder / "trajectory_live.tum").string(), tum_text(live_()));
    Params params = settings_.params;
    write_file((*folder / "params.yaml").string(), to_yaml([&params](ParamVisitor& v) { params.describe(v); }));
    response.success = true;
    response.message = contents(*state->graph) + " saved in " + folder->string();
  } catch (const std::exception& error) {
    response.message = error.what();
  }
  return true;
}

bool MapServices::load(sgraph_slam::LoadMap::Request& request, sgraph_slam::LoadMap::Response& response) {
  response.success = false;
  const auto path = inside(settings_.ros.map_directory, request.path);
  if (!path) {
    response.message = "'" + request.path + "' leads out of the map directory '" + settings_.ros.map_directory + "'";
    return true;
  }
  try {
    const SessionStart start = make_start(map_file(*path).string(), settings_.ros.map_mode, settings_.ros.start);
    response.success = back_end_.begin(start, limit);
    response.message = response.success
                           ? contents(*start.map->snapshot) + " taken up (" + settings_.ros.map_mode + "); its place is searched from here on"
                           : "the back end is busy: the map will be taken up";
  } catch (const std::exception& error) {
    response.message = error.what();
  }
  return true;
}

bool MapServices::pause(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  back_end_.pause(true);
  response.success = true;
  response.message = "nothing enters the map until resume";
  return true;
}

bool MapServices::resume(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  back_end_.pause(false);
  response.success = true;
  response.message = "mapping goes on";
  return true;
}

bool MapServices::reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  response.success = back_end_.reset(limit);
  response.message = response.success ? "the map is empty" : "the back end is busy: the map will be emptied";
  return true;
}

bool MapServices::optimize(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  const std::optional<LiveMap> state = back_end_.optimize(limit);
  response.success = state && publisher_.show_all(*state, limit);
  response.message = response.success ? contents(*state->graph) : "the back end is busy: it will be done later";
  return true;
}

}  // namespace sgraph
