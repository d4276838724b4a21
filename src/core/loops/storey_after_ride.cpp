#include "sgraph_slam/core/loops/storey_after_ride.hpp"

#include <cmath>
#include <cstdint>
#include <iomanip>
#include <sstream>
#include <unordered_set>
#include <vector>

#include "sgraph_slam/core/loops/scan_matcher.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/types/storey.hpp"

namespace sgraph {
namespace {

constexpr double out_of_cabin = 2.0;   // [m] from where the robot stood in it: what lies farther isn't the lift
constexpr double far_enough = 3.0;     // [m] that the robot has gone since: it has seen what is around the door
constexpr double too_far = 8.0;        // [m] after which a storey that has not been recognised is a new one
constexpr double around = 8.0;         // [m] of the lift, of keyframes that have seen what is before its door, and of what they have seen
constexpr double cell = 0.15;          // [m]; points of one wall lie in cells beside each other
constexpr double band_low = -0.3;      // [m] below the sensor and
constexpr double band_high = 0.8;      // above it: walls and furniture, no floors and ceilings
constexpr std::size_t fewest = 300;    // points
constexpr double same_storey = 0.85;   // of them on what was there
constexpr double nearest_floor = 1.0;  // [m] that floors lie apart at least, and
constexpr double sure = 4;             // standard deviations of a height
constexpr double most_moved = 0.3;     // [m], and
constexpr double most_turned = 0.05;   // [rad] that the match may differ from place and heading as they were kept

using Keyframes = std::map<KeyframeId, SceneKeyframe>;

// The keyframes' points in the base frame of `center`.
Cloud together(const Graph& graph, const Keyframes& keyframes, const Pose& T_base_lidar, const std::vector<KeyframeId>& ids,
               const Pose& T_map_center) {
  Cloud all;
  for (const KeyframeId id : ids) {
    const CloudPtr cloud = keyframes.at(id).cloud.get();
    if (!cloud) continue;
    const Pose T = T_map_center.inverse() * *graph.find(id) * T_base_lidar;
    for (const Point& point : cloud->points) all.points.emplace_back(point).set_position((T * point.position().cast<double>()).cast<float>());
  }
  return all;
}

std::uint64_t key(const Eigen::Vector3d& p, int dx, int dy, int dz) {
  const auto part = [](double x, int d) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x / cell)) + d) & 0x1fffffU; };
  return part(p.x(), dx) << 42 | part(p.y(), dy) << 21 | part(p.z(), dz);
}

bool in_band(const Eigen::Vector3d& p, double sensor) { return p.z() > sensor + band_low && p.z() < sensor + band_high; }

// Share of the points beside the lift that lie where the other cloud has some. `T_target_lift`: where the robot stood in the cabin.
std::optional<double> agreement(const Cloud& target, const Cloud& source, const Pose& T_target_source, const Eigen::Vector3d& lift, double sensor) {
  std::unordered_set<std::uint64_t> taken;
  for (const Point& point : target.points) taken.insert(key(point.position().cast<double>(), 0, 0, 0));
  std::size_t points = 0;
  std::size_t known = 0;
  for (const Point& point : source.points) {
    const Eigen::Vector3d p = T_target_source * point.position().cast<double>();
    if (!in_band(p, sensor) || (p - lift).head<2>().norm() < out_of_cabin) continue;
    if ((p - lift).head<2>().norm() > around) continue;
    ++points;
    bool found = false;
    for (int dx = -1; dx <= 1 && !found; ++dx) {
      for (int dy = -1; dy <= 1 && !found; ++dy) {
        for (int dz = -1; dz <= 1 && !found; ++dz) found = taken.count(key(p, dx, dy, dz)) != 0;
      }
    }
    known += found ? 1 : 0;
  }
  if (points < fewest) return std::nullopt;
  return static_cast<double>(known) / static_cast<double>(points);
}

}  // namespace

std::optional<int> storey_after_ride(Committer& committer, const LoopCloser& loops, const Keyframes& keyframes, KeyframeId first,
                                     std::optional<double> sigma, bool& settled) {
  const Graph& graph = committer.graph;
  const KeyframeId now = committer.newest();
  const Pose lift = *graph.find(first);
  const double gone = (graph.find(now)->translation - lift.translation).norm();
  if (gone < far_enough) return std::nullopt;
  settled = gone > too_far;
  std::vector<KeyframeId> since;
  std::map<int, std::vector<KeyframeId>> before;  // on each storey, around the lift
  for (const auto& [id, keyframe] : keyframes) {
    if (!(id < first)) {
      since.push_back(id);
    } else if (keyframe.storey != stairwell && (graph.find(id)->translation - lift.translation).head<2>().norm() < around) {
      before[keyframe.storey].push_back(id);
    }
  }
  const Cloud seen = together(graph, keyframes, loops.T_base_lidar, since, lift);
  struct Candidate {
    int storey;
    KeyframeId nearest;
    ScanMatch match;
    double share;
  };
  std::optional<Candidate> best;
  for (const auto& [storey, ids] : before) {
    // The storey's keyframe that is nearest to the lift; in height they stand on one floor.
    KeyframeId nearest = ids.front();
    const auto distance = [&](KeyframeId id) { return (graph.find(id)->translation - lift.translation).head<2>().norm(); };
    for (const KeyframeId id : ids) nearest = distance(id) < distance(nearest) ? id : nearest;
    const Pose center = *graph.find(nearest);
    if (sigma && std::abs(center.translation.z() - lift.translation.z()) > nearest_floor + sure * *sigma) continue;
    Pose T_map_lift = lift;
    T_map_lift.translation.z() = center.translation.z();
    const Pose expected = center.inverse() * T_map_lift;
    const Cloud known = together(graph, keyframes, loops.T_base_lidar, ids, center);
    const ScanMatch match = match_scans(known, seen, expected, loops.params);
    const Pose moved = expected.inverse() * match.T_target_source;
    const double share = agreement(known, seen, match.T_target_source, expected.translation, loops.T_base_lidar.translation.z()).value_or(0);
    const bool same = match.failure == MatchFailure::none && share > same_storey && moved.translation.norm() < most_moved &&
                      rotation_angle(Eigen::Quaterniond::Identity(), moved.rotation) < most_turned;
    std::ostringstream figures;
    figures << std::setprecision(3) << "walls known " << share << ", moved " << moved.translation.norm() << " m";
    committer.note(same, "storey after a lift: keyframe/" + std::to_string(first.value) + " as storey/" + std::to_string(storey), figures.str());
    if (same && (!best || share > best->share)) best = Candidate{storey, nearest, match, share};
  }
  if (!best) return std::nullopt;
  Vector6 tiny;
  tiny.setConstant(1e-6);
  Transaction edit;
  edit.reason = "keyframe/" + std::to_string(first.value) + " back on storey/" + std::to_string(best->storey);
  add_factor(edit,
             Se3Between{best->nearest, first, best->match.T_target_source, SqrtInformation<6>::from_covariance(best->match.covariance, tiny),
                        Se3Between::Source::loop},
             RobustLoss::cauchy(loops.params.loss_scale));
  if (!committer.commit(edit).ok()) return std::nullopt;
  settled = true;
  return best->storey;
}

}  // namespace sgraph
