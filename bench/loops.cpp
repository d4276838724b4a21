// Maps the keyframes of a run again with an odometry that is made wrong, with and without loops by appearance:
//   loops RUN [SCALE [HEADING]]      RUN: run folder of run_world (map.sgmap, ground_truth.tum); 0.05 of the way, 0.5 degrees a metre by default
// The covariance that the odometry claims is as large as its error. Prints the keyframes' error (ATE) and what was decided about loops.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "sgraph_slam/core/eval/trajectory_error.hpp"
#include "sgraph_slam/core/io/tum.hpp"
#include "sgraph_slam/core/localisation/merge_maps.hpp"
#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/store/stored_map.hpp"

namespace sgraph {
namespace {

// The same keyframes as an odometry sees them whose steps are too long and which turns while it moves.
std::vector<LocatedKeyframe> made_wrong(std::vector<LocatedKeyframe> seen, double scale, double heading) {
  Pose T_wrong = seen.front().keyframe.T_odom_base;
  Pose last = T_wrong;
  for (LocatedKeyframe& each : seen) {
    Keyframe& keyframe = each.keyframe;
    Pose step = last.inverse() * keyframe.T_odom_base;
    last = keyframe.T_odom_base;
    const double length = step.translation.norm();
    step.translation *= 1 + scale;
    Vector6 turn = Vector6::Zero();
    turn[2] = heading * length;
    const Pose T_right = keyframe.T_odom_base;
    T_wrong = T_wrong * step * se3_exp(turn);
    keyframe.T_odom_base = T_wrong;
    for (StampedPose& scan : keyframe.scans) scan.pose = T_wrong * T_right.inverse() * scan.pose;
    Vector6 sigma = Vector6::Zero();
    sigma[2] = std::abs(heading) * length;
    sigma[3] = sigma[4] = std::abs(scale) * length;
    keyframe.covariance += sigma.cwiseAbs2().asDiagonal().toDenseMatrix();
  }
  return seen;
}

void map(const std::string& name, const std::vector<LocatedKeyframe>& seen, const Trajectory& truth, const Pose& T_base_lidar,
         const MappingParams& params) {
  BackEnd back_end(params, T_base_lidar);
  for (const LocatedKeyframe& each : seen) back_end.process(each.keyframe, each.segments);
  const GraphSnapshotPtr result = back_end.optimize();
  Trajectory estimate, odometry;
  for (const auto& [id, keyframe] : result->keyframes) {
    estimate.push_back({keyframe.stamp, keyframe.T_map_base});
    odometry.push_back({keyframe.stamp, keyframe.T_odom_base});
  }
  const auto ate = [&truth](const Trajectory& trajectory) {
    const auto pairs = pair_by_stamp(trajectory, truth, 0.06);
    return statistics_of(absolute_errors(pairs, align(pairs))).translation;
  };
  int accepted = 0, refused = 0;
  for (const Decision& decision : back_end.decisions()) {
    if (decision.what.rfind("loop", 0) != 0) continue;
    (decision.accepted ? accepted : refused) += 1;
    if (std::getenv("SGRAPH_SHOW") != nullptr)
      std::printf("  %s %s: %s\n", decision.what.c_str(), decision.accepted ? "accepted" : "refused", decision.reason.c_str());
  }
  std::printf("- %s: odometry %.3f m, graph %.3f m (largest %.3f); loops accepted %d, refused %d; %zu planes\n", name.c_str(), ate(odometry).rmse,
              ate(estimate).rmse, ate(estimate).max, accepted, refused, result->planes.size());
}

int run(const std::string& folder, double scale, double heading) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // a line as soon as it is known
  const StoredMap stored = read_map(folder + "/map.sgmap", Clouds::all);
  const Trajectory truth = read_tum(folder + "/ground_truth.tum");
  const Pose T_base_lidar = stored.sessions.begin()->second.T_base_lidar;
  const auto seen = made_wrong(located_keyframes(stored, stored.sessions.begin()->first), scale, heading);
  MappingParams params;
  map("with loops", seen, truth, T_base_lidar, params);
  params.loops.appearance = false;
  map("without loops by appearance", seen, truth, T_base_lidar, params);
  return 0;
}

}  // namespace
}  // namespace sgraph

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "loops RUN [SCALE [HEADING]]\n");
    return 2;
  }
  try {
    return sgraph::run(argv[1], argc > 2 ? std::atof(argv[2]) : 0.05, (argc > 3 ? std::atof(argv[3]) : 0.5) * M_PI / 180);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "loops: %s\n", error.what());
    return 1;
  }
}
