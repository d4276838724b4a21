#include "sgraph_slam/core/loops/close_loop.hpp"

#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>

#include <Eigen/Eigenvalues>

#include "sgraph_slam/core/loops/scan_matcher.hpp"
#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph {
namespace {

constexpr int neighbours = 2;     // keyframes before and after the old one whose clouds are matched together
constexpr int marginals_age = 5;  // keyframes

// The nearest keyframe far back along the path.
std::optional<KeyframeId> candidate(const Graph& graph, const std::map<KeyframeId, SceneKeyframe>& keyframes, const OdometryDrift& drift,
                                    KeyframeId now, const LoopParams& params) {
  const Eigen::Vector3d here = graph.find(now)->translation;
  std::optional<KeyframeId> nearest;
  double least = params.max_distance;
  for (const auto& [id, keyframe] : keyframes) {
    if (drift.path(id, now) < params.min_path) break;
    const double distance = (graph.find(id)->translation - here).norm();
    if (keyframe.storey != keyframes.at(now).storey) continue;
    if (distance < least && keyframe.cloud) {
      least = distance;
      nearest = id;
    }
  }
  return nearest;
}

// How uncertain the graph is about the motion between the two [m]: the largest standard deviation of the translation, in the newer one's frame.
// Nothing when the graph doesn't know.
std::optional<double> relative_sigma(const Graph& graph, const Marginals& marginals, KeyframeId known, KeyframeId from) {
  const auto joint = marginals.joint({from, known});
  if (!joint) return std::nullopt;
  Eigen::Matrix<double, 6, 12> J;
  J << -se3_adjoint(graph.find(known)->inverse() * *graph.find(from)), Matrix6::Identity();
  const Matrix6 covariance = J * *joint * J.transpose();
  return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance.bottomRightCorner<3, 3>()).eigenvalues().maxCoeff()));
}

// The clouds around a keyframe, in its base frame. Those of another storey stand elsewhere: a lift's cabin was left behind there too.
Cloud cloud_around(const Graph& graph, const std::map<KeyframeId, SceneKeyframe>& keyframes, const Pose& T_base_lidar, KeyframeId center) {
  Cloud all;
  const Pose T_center_map = graph.find(center)->inverse();
  for (auto keyframe = keyframes.lower_bound({center.value - neighbours});
       keyframe != keyframes.end() && keyframe->first.value <= center.value + neighbours; ++keyframe) {
    if (keyframe->second.storey != keyframes.at(center).storey) continue;
    const CloudPtr cloud = keyframe->second.cloud.get();
    if (!cloud) continue;
    const Pose T = T_center_map * *graph.find(keyframe->first) * T_base_lidar;
    for (const Point& point : cloud->points) {
      const Eigen::Vector3f p = (T * point.position().cast<double>()).cast<float>();
      Point& moved = all.points.emplace_back(point);
      moved.x = p.x();
      moved.y = p.y();
      moved.z = p.z();
    }
  }
  return all;
}

}  // namespace

bool close_loop(Committer& committer, LoopCloser& loops, const std::map<KeyframeId, SceneKeyframe>& keyframes, const OdometryDrift& drift,
                MarginalsCache& cache) {
  const LoopParams& params = loops.params;
  const Graph& graph = committer.graph;
  const KeyframeId now = committer.newest();
  if (!params.enabled || (loops.last_tried.valid() && drift.path(loops.last_tried, now) < params.min_interval)) return false;
  const auto from = candidate(graph, keyframes, drift, now, params);
  if (!from) return false;
  loops.last_tried = now;
  // What the walls hold already needs no scan matching.
  const Marginals* marginals = cache.get(graph, marginals_age);
  const auto sigma = marginals ? relative_sigma(graph, *marginals, cache.newest(), *from) : std::nullopt;
  if (sigma && *sigma < params.min_sigma) return false;
  const std::string what = "loop keyframe/" + std::to_string(from->value) + " to keyframe/" + std::to_string(now.value);
  const Pose expected = graph.find(*from)->inverse() * *graph.find(now);
  const ScanMatch match = match_scans(cloud_around(graph, keyframes, loops.T_base_lidar, *from),
                                      cloud_around(graph, keyframes, loops.T_base_lidar, now), expected, params);
  std::ostringstream figures;
  figures << std::setprecision(3) << "fitness " << match.fitness << " m^2, overlap " << match.overlap;
  if (match.failure != MatchFailure::none) {
    committer.note(false, what, std::string(to_string(match.failure)) + ": " + figures.str());
    return false;
  }
  Vector6 tiny;
  tiny.setConstant(1e-6);
  const Se3Between loop{*from, now, match.T_target_source, SqrtInformation<6>::from_covariance(match.covariance, tiny), Se3Between::Source::loop};
  marginals = cache.get(graph, 0);
  if (!marginals) {  // a wrong loop is worse than a missed one
    committer.note(false, what, "the graph doesn't know how far off it may be: " + figures.str());
    return false;
  }
  const double chi_square = innovation_chi_square(graph, *marginals, loop);
  figures << ", chi-square " << chi_square;
  const bool consistent = chi_square < params.chi_square;  // false for NaN
  committer.note(consistent, what, (consistent ? "" : "contradicts the graph: ") + figures.str());
  if (!consistent) return false;
  Transaction edit;
  edit.reason = what;
  add_factor(edit, loop, RobustLoss::cauchy(params.loss_scale));
  return committer.commit(edit).ok();
}

}  // namespace sgraph
