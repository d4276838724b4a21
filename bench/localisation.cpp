// Starts of a robot anywhere on the way of one run, searched for in the map of another of the same world:
//   localisation MAP_RUN QUERY_RUN [STARTS [--stranger]]      --stranger: the runs are of different buildings, so that any place found is wrong
// Both are run folders of run_world (map.sgmap, ground_truth.tum). Prints how many were found, right and wrong, after how much way and time.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "sgraph_slam/core/io/tum.hpp"
#include "sgraph_slam/core/localisation/merge_maps.hpp"
#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/store/stored_map.hpp"
#include "sgraph_slam/core/util/statistics.hpp"

namespace sgraph {
namespace {

constexpr double longest_way = 12;       // [m] after which a search is given up
constexpr double right_distance = 0.10;  // [m]
constexpr double right_angle = 0.01745;  // [rad]

Pose truth_at(const Trajectory& truth, Stamp stamp) {
  const auto after = std::lower_bound(truth.begin(), truth.end(), stamp, [](const StampedPose& p, Stamp s) { return p.stamp < s; });
  if (after == truth.begin()) return truth.front().pose;
  if (after == truth.end()) return truth.back().pose;
  const auto before = std::prev(after);
  return interpolate(before->pose, after->pose, (stamp - before->stamp) / (after->stamp - before->stamp));
}

int run(const std::string& map_run, const std::string& query_run, std::size_t starts, bool stranger) {
  const StoredMap map = read_map(map_run + "/map.sgmap", Clouds::none);
  const StoredMap query = read_map(query_run + "/map.sgmap", Clouds::none);
  const Trajectory map_truth = read_tum(map_run + "/ground_truth.tum");
  const Trajectory query_truth = read_tum(query_run + "/ground_truth.tum");
  const auto reference = std::make_shared<const ReferenceMap>(snapshot_of(map), map.sessions.begin()->second.T_base_lidar);
  const std::vector<LocatedKeyframe> seen = located_keyframes(query, query.sessions.begin()->first);
  const Pose T_base_lidar = query.sessions.begin()->second.T_base_lidar;
  // A search may need some way: the last metres of a run are no start.
  std::size_t last = seen.size();
  for (double way = 0; last > 1 && way < 6; --last)
    way += (seen[last - 1].keyframe.T_odom_base.translation - seen[last - 2].keyframe.T_odom_base.translation).norm();
  starts = std::min(starts, last);
  int right = 0, wrong = 0, ambiguous = 0, lost = 0, late = 0;
  std::vector<double> ways, times, errors;
  for (std::size_t s = 0; s < starts; ++s) {
    const std::size_t first = s * last / starts;
    Localiser localiser(reference, T_base_lidar);
    Localisation answer;
    std::size_t at = first;
    for (; at < seen.size(); ++at) {
      answer = localiser.add(seen[at]);
      if (answer.result == LocalisationResult::found || answer.travelled > longest_way) break;
    }
    times.push_back(answer.milliseconds);
    if (answer.result != LocalisationResult::found) {
      (answer.result == LocalisationResult::ambiguous ? ambiguous : lost) += 1;
      if (std::getenv("SGRAPH_SHOW") != nullptr) std::printf("start %zu: %s, %s\n", first, to_string(answer.result), answer.reason.c_str());
      continue;
    }
    // Against the truth by the keyframe of the map that is nearest: the map's own error is not the search's.
    double least = HUGE_VAL;
    Pose T_world_map;
    for (const auto& [id, pose] : map.poses) {
      const double distance = (pose.translation - answer.T_map_base.translation).norm();
      if (distance >= least) continue;
      least = distance;
      T_world_map = truth_at(map_truth, map.keyframes.at(id).stamp) * pose.inverse();
    }
    const Pose error = truth_at(query_truth, seen[at].keyframe.stamp).inverse() * T_world_map * answer.T_map_base;
    const double angle = 2 * std::acos(std::min(1.0, std::abs(error.rotation.w())));
    errors.push_back(error.translation.norm());
    ways.push_back(answer.travelled);
    late += answer.travelled > 5;
    const bool good = !stranger && errors.back() < right_distance && angle < right_angle;
    (good ? right : wrong) += 1;
    if (!good) std::printf("WRONG start %zu: %.3f m %.2f deg off; %s\n", first, errors.back(), angle * 180 / M_PI, answer.reason.c_str());
  }
  std::printf(
      "%s in %s: %zu starts, right %d (after 5 m: %d), wrong %d, ambiguous %d, not found %d; way p50 %.1f p99 %.1f m; search p50 %.0f p99 %.0f ms; "
      "error p50 %.3f p99 %.3f m\n",
      query_run.c_str(), map_run.c_str(), starts, right, late, wrong, ambiguous, lost, quantile(ways, 0.5), quantile(ways, 0.99),
      quantile(times, 0.5), quantile(times, 0.99), quantile(errors, 0.5), quantile(errors, 0.99));
  return wrong > 0 ? 1 : 0;
}

}  // namespace
}  // namespace sgraph

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "localisation MAP_RUN QUERY_RUN [STARTS]\n");
    return 2;
  }
  try {
    return sgraph::run(argv[1], argv[2], argc > 3 ? static_cast<std::size_t>(std::atoi(argv[3])) : 50,
                       argc > 4 && std::string(argv[4]) == "--stranger");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "localisation: %s\n", error.what());
    return 1;
  }
}
