// Looks at map files, checks them, and makes run folders of them.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <iostream>

#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/io/map_folder.hpp"
#include "sgraph_slam/core/localisation/changes.hpp"
#include "sgraph_slam/core/localisation/merge_maps.hpp"
#include "sgraph_slam/core/params/params_io.hpp"
#include "sgraph_slam/core/pipeline/pipeline.hpp"
#include "sgraph_slam/core/store/stored_map.hpp"
#include "sgraph_slam/core/util/resources.hpp"

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

// What each further session found otherwise.
void show_changes(const std::string& path) {
  const StoredMap map = read_map(path, Clouds::none);
  for (const auto& [id, session] : map.sessions) {
    if (id == map.sessions.begin()->first) continue;
    const std::vector<MapChange> changes = changes_of(map, id);
    std::printf("  session %lld: %zu changes\n", static_cast<long long>(id), changes.size());
    for (const MapChange& change : changes) std::printf("    %s\n", to_string(change).c_str());
  }
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

// Pose of a session's first keyframe.
Pose first_pose(const StoredMap& map, std::int64_t session) {
  for (const auto& [id, pose] : map.poses) {
    if (map.session_of.at(id) == session) return pose;
  }
  return {};
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

// Adds the sessions of maps one by one, each into a file of its own, so that whatever happens no map is harmed; the last one becomes `out`.
class Merger {
 public:
  explicit Merger(const std::string& out) : out_(out) {
    if (std::filesystem::exists(out)) throw StoreError(out + ": it exists already");
  }
  ~Merger() { remove(current_); }
  Merger(const Merger&) = delete;
  Merger& operator=(const Merger&) = delete;

  // Whether its place was found.
  bool add(const StoredMap& map, std::int64_t session, const std::string& name, const std::optional<Pose>& near) {
    const std::string next = out_ + ".part" + std::to_string(count_++);
    remove(next);
    const Localisation place = add_session(map, session, current_, next, near, MappingParams{});
    std::cout << name << ", session " << session << ": " << to_string(place.result) << " (" << place.reason << ")" << std::endl;
    const bool found = place.result == LocalisationResult::found;
    remove(found ? current_ : next);
    if (found) current_ = next;
    return found;
  }

  void finish() {
    std::filesystem::rename(current_, out_);
    current_.clear();
  }

 private:
  static void remove(const std::string& path) {
    std::error_code error;
    if (path.empty()) return;
    for (const char* part : {"", "-wal", "-shm"}) std::filesystem::remove(path + part, error);
  }

  std::string out_;
  std::string current_;
  int count_ = 0;
};

// Joins maps of one building. Sessions that do not find their place are left out; exit status 1 then.
int merge(const std::vector<std::string>& files, const std::string& out) {
  Merger merger(out);
  int refused = 0;
  Pose T_new_old;  // a map begins where its first session does
  for (std::size_t i = 0; i < files.size(); ++i) {
    const StoredMap map = read_map(files[i], Clouds::none);
    if (map.sessions.empty()) throw StoreError(files[i] + ": there is nothing in it yet");
    if (i == 0) T_new_old = first_pose(map, map.sessions.begin()->first).inverse();
    for (const auto& [id, session] : map.sessions) {
      std::optional<Pose> near;  // the first file's sessions lie in one frame already
      if (i == 0 && id != map.sessions.begin()->first) near = T_new_old * first_pose(map, id);
      refused += merger.add(map, id, files[i], near) ? 0 : 1;
    }
  }
  merger.finish();
  if (refused > 0) std::cout << refused << " sessions are not in " << out << ": no place in the map agrees with them" << std::endl;
  return refused > 0 ? 1 : 0;
}

// A map without some of its sessions, made again from the others.
void split(const std::string& path, const std::vector<std::int64_t>& without, const std::string& out) {
  const StoredMap map = read_map(path, Clouds::none);
  for (const std::int64_t id : without) {
    if (map.sessions.count(id) == 0) throw StoreError(path + ": there is no session " + std::to_string(id));
  }
  Merger merger(out);
  std::optional<Pose> T_new_old;  // the first session that stays begins the new map's frame
  for (const auto& [id, session] : map.sessions) {
    if (std::find(without.begin(), without.end(), id) != without.end()) continue;
    std::optional<Pose> near;
    if (T_new_old) near = *T_new_old * first_pose(map, id);
    if (!merger.add(map, id, path, near)) throw StoreError(path + ": session " + std::to_string(id) + " does not find its place without the others");
    if (!T_new_old) T_new_old = first_pose(map, id).inverse();
  }
  if (!T_new_old) throw StoreError(path + ": no session would be left");
  merger.finish();
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
  bool changes = false;
  info->add_flag("--changes", changes,
                 "What each session found otherwise than those before it: walls new or gone, doors closed or opened, furniture moved");
  for (CLI::App* command : {info, checking}) command->add_option("FILE", files, "Map files")->required();
  exporting->add_option("FILE", files, "Map file")->required()->expected(1);
  CLI::App* merging = app.add_subcommand("merge", "Join maps of one building; sessions of another are left out, exit status 1");
  merging->add_option("FILE", files, "Map files; the first one's frame is kept")->required();
  merging->add_option("-o,--out", out, "Map file to write")->required();
  std::vector<std::int64_t> sessions;
  CLI::App* splitting = app.add_subcommand("split", "A map without some of its sessions");
  splitting->add_option("FILE", files, "Map file")->required()->expected(1);
  splitting->add_option("--session", sessions, "Session to leave out (maps info shows their numbers)")->required();
  splitting->add_option("-o,--out", out, "Map file to write")->required();
  exporting->add_option("-o,--out", out, "Folder to write")->required();
  try {
    app.parse(argc, argv);
    if (info->parsed()) {
      for (const std::string& path : files) {
        show(path);
        if (changes) show_changes(path);
      }
    } else if (checking->parsed()) {
      return check(files);
    } else if (merging->parsed()) {
      return merge(files, out);
    } else if (splitting->parsed()) {
      split(files.front(), sessions, out);
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

int main(int argc, char** argv) {
  try {
    sgraph::return_freed_memory();
    return sgraph::main_of_maps(argc, argv);
  } catch (...) {  // from what is done before arguments are read
    std::fputs("maps: cannot start\n", stderr);
    return 1;
  }
}
