#include "sgraph_slam/core/io/map_folder.hpp"

#include <optional>
#include <sstream>
#include <vector>

#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/io/floor_plan.hpp"
#include "sgraph_slam/core/io/graph_json.hpp"
#include "sgraph_slam/core/io/map_cloud.hpp"
#include "sgraph_slam/core/io/mirror_images.hpp"
#include "sgraph_slam/core/io/occupancy_grid.hpp"
#include "sgraph_slam/core/io/seen_through.hpp"
#include "sgraph_slam/core/io/storey_view.hpp"
#include "sgraph_slam/core/io/tum.hpp"

namespace sgraph {

std::string tum_text(const Trajectory& trajectory) {
  std::ostringstream text;
  write_tum(trajectory, text);
  return text.str();
}

std::string decisions_csv(const DecisionLog& decisions) {
  std::string text = "keyframe,verdict,what,reason\n";
  const auto quoted = [](const std::string& words) {
    std::string cell = "\"";
    for (const char c : words) cell += c == '"' ? std::string("\"\"") : std::string(1, c);
    return cell + '"';
  };
  for (const Decision& d : decisions)
    text += std::to_string(d.keyframe.value) + (d.accepted ? ",accepted," : ",refused,") + quoted(d.what) + ',' + quoted(d.reason) + '\n';
  return text;
}

namespace {

// The grid and the drawings of a storey, under each of the names: a suffix comes before the dot.
void write_plans(const std::string& base, const std::vector<std::string>& suffixes, const GraphSnapshot& snapshot, const Trajectory& path,
                 const Pose& T_base_lidar, const OutputParams& params, const LeaveOut& leave_out) {
  const OccupancyGrid grid = make_occupancy_grid(snapshot, T_base_lidar, params, leave_out);
  const FloorPlan plan = make_floor_plan(snapshot, grid, path);
  const std::string picture = floor_plan_png(plan);
  for (const std::string& suffix : suffixes) {
    write_file(base + "map" + suffix + ".pgm", pgm_bytes(grid));
    write_file(base + "map" + suffix + ".yaml", map_yaml(grid, "map" + suffix + ".pgm"));
    write_file(base + "floor_plan" + suffix + ".png", picture);
    write_file(base + "floor_plan" + suffix + ".svg", floor_plan_svg(plan));
    write_file(base + "floor_plan" + suffix + ".dxf", floor_plan_dxf(plan));
  }
}

}  // namespace

void write_map(const std::string& folder, const GraphSnapshot& snapshot, const Trajectory& path, const Pose& T_base_lidar,
               const OutputParams& params) {
  make_folder(folder);
  const std::string base = folder + '/';
  Trajectory keyframes;
  for (const auto& [id, keyframe] : snapshot.keyframes) keyframes.push_back({keyframe.stamp, keyframe.T_map_base});
  write_file(base + "keyframes.tum", tum_text(keyframes));
  write_file(base + "graph.json", graph_json(snapshot));
  write_file(base + "decisions.csv", decisions_csv(snapshot.decisions));
  std::optional<SeenThrough> gone;
  std::optional<MirrorImages> images;
  if (!params.keep_gone) gone.emplace(snapshot, T_base_lidar);
  if (!params.keep_images) images.emplace(snapshot, T_base_lidar);
  const LeaveOut leave_out = [&](const Eigen::Vector3d& p_map) { return (gone && (*gone)(p_map)) || (images && (*images)(p_map)); };
  write_file(base + "map.pcd", pcd_bytes(map_cloud(snapshot, T_base_lidar, params.cloud_leaf, leave_out)));
  const std::set<int> storeys = storeys_of(snapshot);
  if (storeys.size() < 2) {
    write_plans(base, {""}, snapshot, path, T_base_lidar, params, leave_out);
    return;
  }
  for (const int storey : storeys) {
    const GraphSnapshot part = of_storey(snapshot, storey);
    std::vector<std::string> suffixes{'_' + std::to_string(storey)};
    if (storey == *storeys.begin()) suffixes.emplace_back();
    write_plans(base, suffixes, part, path_of(part, path), T_base_lidar, params, leave_out);
  }
}

}  // namespace sgraph
