// Looks at map files, checks them, and makes run folders of them.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>

#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/io/map_folder.hpp"
#include "sgraph_slam/core/params/params_io.hpp"
#include "sgraph_slam/core/pipeline/pipeline.hpp"
#include "sgraph_slam/core/store/stored_map.hpp"

namespace sgraph {
namespace {

std::string stamp_text(Stamp stamp) {
  const auto seconds = static_cast<std::time_t>(stamp.nanoseconds / 1'000'000'000);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[40];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &utc);
  return text;
}

void show(const std::string& path) {
  const MapSummary map = summarize_map(path);
  std::printf("%s: schema %d, %.1f MiB (clouds %.1f MiB, %lld points)\n", path.c_str(), map.schema, static_cast<double>(map.bytes) / (1 << 20),
              static_cast<double>(map.cloud_bytes) / (1 << 20), static_cast<long long>(map.points));
  std::printf("  %lld keyframes, %lld planes, %lld rooms, %lld corridors, %lld factors, %lld merges\n", static_cast<long long>(map.keyframes),
              static_cast<long long>(map.planes), static_cast<long long>(map.rooms), static_cast<long long>(map.corridors),
              static_cast<long long>(map.factors), static_cast<long long>(map.merges));
  for (const MapSummary::Session& s : map.sessions) {
    std::printf("  session %lld: %s, %.0f s, %lld keyframes, %.1f m, from %s\n", static_cast<long long>(s.session.id),
                stamp_text(s.session.started).c_str(), s.keyframes > 0 ? s.ended - s.session.started : 0.0, static_cast<long long>(s.keyframes),
                s.path, s.session.source.c_str());
  }
}

// The poses of one session's scans.
Trajectory trajectory_of(const GraphSnapshot& snapshot, const StoredMap& map, std::int64_t session) {
  GraphSnapshot part;
  for (const auto& [id, keyframe] : snapshot.keyframes) {
    if (map.session_of.at(id) == session) part.keyframes[id] = keyframe;
  }
  return corrected_trajectory(part);
}

// Clouds of another robot, as the first one's LiDAR would have them.
void move_clouds(StoredMap& map) {
  const Pose T_base_lidar = map.sessions.begin()->second.T_base_lidar;
  for (auto& [id, keyframe] : map.keyframes) {
    const auto session = map.sessions.find(map.session_of.at(id));
    if (session == map.sessions.end() || !keyframe.cloud) continue;
    const Pose T = T_base_lidar.inverse() * session->second.T_base_lidar;
    if (T.translation.norm() < 1e-9 && std::abs(T.rotation.w()) > 1 - 1e-12) continue;
    Cloud moved = *keyframe.cloud;
    for (Point& p : moved.points) p.set_position((T * p.position().cast<double>()).cast<float>());
    for (Viewpoint& v : moved.viewpoints) v.position = T * v.position;
    keyframe.cloud = std::make_shared<const Cloud>(std::move(moved));
  }
}

void export_map(const std::string& path, const std::string& folder) {
  StoredMap map = read_map(path, Clouds::all);
  if (map.sessions.empty()) throw StoreError(path + ": there is nothing in it yet");
  for (const std::string& fault : map.faults) std::cerr << "maps: " << path << ": " << fault << '\n';
  move_clouds(map);
  const GraphSnapshot snapshot = snapshot_of(map);
  Params params;
  const StoredSession& newest = map.sessions.rbegin()->second;
  std::map<std::int64_t, Trajectory> ways;
  for (const auto& [id, session] : map.sessions) ways[id] = trajectory_of(snapshot, map, id);
  write_map(folder, snapshot, ways.rbegin()->second, map.sessions.begin()->second.T_base_lidar, params.output);
  write_file(folder + "/trajectory.tum", tum_text(ways.rbegin()->second));
  if (ways.size() > 1) {
    for (const auto& [id, way] : ways) write_file(folder + "/trajectory_" + std::to_string(id) + ".tum", tum_text(way));
  }
  if (!newest.parameters.empty()) write_file(folder + "/params.yaml", newest.parameters);
  std::cout << path << " exported to " << folder << std::endl;
}

int check(const std::vector<std::string>& files) {
  int bad = 0;
  for (const std::string& path : files) {
    std::vector<std::string> faults;
    try {
      faults = check_map(path);
    } catch (const StoreError& error) {
      std::cout << error.what() << '\n';
      ++bad;
      continue;
    }
    for (const std::string& fault : faults) std::cout << path << ": " << fault << '\n';
    if (faults.empty()) std::cout << path << ": whole" << '\n';
    bad += faults.empty() ? 0 : 1;
  }
  return bad > 0 ? 1 : 0;
}

int main_of_maps(int argc, char** argv) {
  CLI::App app("Map files: what they hold, whether they are whole, run folders of them", "maps");
  app.require_subcommand(1);
  std::vector<std::string> files;
  std::string out;
  CLI::App* info = app.add_subcommand("info", "What the files hold");
  CLI::App* checking = app.add_subcommand("check", "Whether the files are whole; exit status 1 when one is not");
  CLI::App* exporting = app.add_subcommand("export", "Write the files of a run folder: graph, clouds, grid, plans, trajectory");
  for (CLI::App* command : {info, checking}) command->add_option("FILE", files, "Map files")->required();
  exporting->add_option("FILE", files, "Map file")->required()->expected(1);
  exporting->add_option("-o,--out", out, "Folder to write")->required();
  try {
    app.parse(argc, argv);
    if (info->parsed()) {
      for (const std::string& path : files) show(path);
    } else if (checking->parsed()) {
      return check(files);
    } else {
      export_map(files.front(), out);
    }
    return 0;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << "maps: " << error.what() << '\n';
  }
  return 1;
}

}  // namespace
}  // namespace sgraph

int main(int argc, char** argv) { return sgraph::main_of_maps(argc, argv); }
