#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>

#include <Eigen/Eigenvalues>

#include "sgraph_slam/core/loops/scan_matcher.hpp"
#include "sgraph_slam/core/mapping/map_state.hpp"
#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph {
namespace {

constexpr int neighbours = 2;     // keyframes before and after the old one whose clouds are matched together
constexpr int marginals_age = 5;  // keyframes

// The nearest keyframe far back along the path.
std::optional<KeyframeId> candidate(const MapState& state) {
  const LoopParams& params = state.params.loops;
  const KeyframeId now = state.newest();
  const Eigen::Vector3d here = state.graph.find(now)->translation;
  std::optional<KeyframeId> nearest;
  double least = params.max_distance;
  for (const auto& [id, keyframe] : state.keyframes) {
    if (state.drift.path(id, now) < params.min_path) break;
    const double distance = (state.graph.find(id)->translation - here).norm();
    if (distance < least && keyframe.cloud && !keyframe.cloud->empty()) {
      least = distance;
      nearest = id;
    }
  }
  return nearest;
}

// How uncertain the graph is about the motion between the two [m]: the largest standard deviation of the translation, in the newer one's frame.
double relative_sigma(const MapState& state, const Marginals& marginals, KeyframeId known, KeyframeId from) {
  const auto joint = marginals.joint({from, known});
  if (!joint) return 0;
  Eigen::Matrix<double, 6, 12> J;
  J << -se3_adjoint(state.graph.find(known)->inverse() * *state.graph.find(from)), Matrix6::Identity();
  const Matrix6 covariance = J * *joint * J.transpose();
  return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance.bottomRightCorner<3, 3>()).eigenvalues().maxCoeff()));
}

// The clouds around a keyframe, in its base frame.
Cloud cloud_around(const MapState& state, KeyframeId center) {
  Cloud all;
  const Pose T_center_map = state.graph.find(center)->inverse();
  for (auto keyframe = state.keyframes.lower_bound({center.value - neighbours});
       keyframe != state.keyframes.end() && keyframe->first.value <= center.value + neighbours; ++keyframe) {
    if (!keyframe->second.cloud) continue;
    const Pose T = T_center_map * *state.graph.find(keyframe->first) * state.T_base_lidar;
    for (const Point& point : keyframe->second.cloud->points) {
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

bool close_loop(MapState& state) {
  const LoopParams& params = state.params.loops;
  const KeyframeId now = state.newest();
  if (!params.enabled || (state.last_loop_tried.valid() && state.drift.path(state.last_loop_tried, now) < params.min_interval)) return false;
  const auto from = candidate(state);
  if (!from) return false;
  state.last_loop_tried = now;
  const Marginals* marginals = state.marginals.get(state.graph, marginals_age);
  // What the walls hold already needs no scan matching.
  if (!marginals || relative_sigma(state, *marginals, state.marginals.newest(), *from) < params.min_sigma) return false;
  const std::string what = "loop keyframe/" + std::to_string(from->value) + " to keyframe/" + std::to_string(now.value);
  const Pose expected = state.graph.find(*from)->inverse() * *state.graph.find(now);
  const ScanMatch match = match_scans(cloud_around(state, *from), cloud_around(state, now), expected, params);
  std::ostringstream figures;
  figures << std::setprecision(3) << "fitness " << match.fitness << " m^2, overlap " << match.overlap;
  if (match.failure != MatchFailure::none) {
    state.log.push_back({now, false, what, std::string(to_string(match.failure)) + ": " + figures.str()});
    return false;
  }
  Vector6 tiny;
  tiny.setConstant(1e-6);
  const Se3Between loop{*from, now, match.T_target_source, SqrtInformation<6>::from_covariance(match.covariance, tiny), Se3Between::Source::loop};
  marginals = state.marginals.get(state.graph, 0);
  const double chi_square = marginals ? innovation_chi_square(state.graph, *marginals, loop) : params.chi_square;
  figures << ", chi-square " << chi_square;
  const bool consistent = chi_square < params.chi_square;  // false for NaN
  state.log.push_back({now, consistent, what, (consistent ? "" : "contradicts the graph: ") + figures.str()});
  if (!consistent) return false;
  Transaction edit;
  edit.reason = what;
  add_factor(edit, loop, RobustLoss::cauchy(params.loss_scale));
  return commit(state, edit).ok();
}

}  // namespace sgraph
