#include "sgraph_slam/core/loops/close_loop_by_appearance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/search/layout_builder.hpp"
#include "sgraph_slam/core/search/verdict.hpp"

namespace sgraph {
namespace {

constexpr double query_path = 12;        // of the way that is searched for [m], as in localisation
constexpr double candidate_path = 40;    // after which a candidate is forgotten [m]
constexpr int marginals_age = 5;         // keyframes
constexpr double agrees = 0.3;           // [m] of a place from where the graph has the robot: there is nothing to close
constexpr double agrees_angle = 0.05;    // [rad]
constexpr double chi_square_3 = 11.34;   // 99 %, 3 degrees of freedom: two searches that contradict each other
constexpr double chi_square_6 = 16.8;    // 99 %, 6 degrees of freedom: a loop that contradicts the graph
constexpr double found_angle = 0.01;     // standard deviation of a place that was found [rad]
constexpr double found_distance = 0.05;  // [m]
constexpr double free_angle = 0.05;      // of roll and pitch, which walls from above don't tell [rad]
constexpr double free_height = 0.5;      // [m]

Pose turn(const Eigen::Quaterniond& q) { return {q, Eigen::Vector3d::Zero()}; }

// Standard deviation of a place that was found: rotation, translation.
Vector6 found_sigma() {
  Vector6 sigma;
  sigma << free_angle, free_angle, found_angle, found_distance, found_distance, free_height;
  return sigma;
}

// The keyframes of a map's old part and those of the last metres, in one storey.
struct Parts {
  KeyframeId first_old, last_old, first_new;
  int storey = 0;
  const std::map<KeyframeId, SceneKeyframe>* keyframes = nullptr;

  [[nodiscard]] bool is_here(KeyframeId id) const {
    const auto keyframe = keyframes->find(id);
    return keyframe != keyframes->end() && keyframe->second.storey == storey;
  }
  [[nodiscard]] bool is_old(KeyframeId id) const { return !(last_old < id) && is_here(id); }
  [[nodiscard]] bool is_new(KeyframeId id) const { return !(id < first_new) && is_here(id); }
};

std::optional<Parts> parts_of(const std::map<KeyframeId, SceneKeyframe>& keyframes, const OdometryDrift& drift, KeyframeId now, double min_path) {
  Parts parts;
  parts.keyframes = &keyframes;
  parts.storey = keyframes.at(now).storey;
  if (parts.storey == stairwell) return std::nullopt;
  parts.first_old = keyframes.begin()->first;
  parts.first_new = now;
  for (const auto& [id, keyframe] : keyframes) {
    const double path = drift.path(id, now);
    if (path >= min_path + query_path) parts.last_old = id;
    if (path <= query_path) {
      parts.first_new = id;
      break;
    }
  }
  const bool been_here = std::any_of(keyframes.begin(), keyframes.end(), [&](const auto& entry) { return parts.is_old(entry.first); });
  return parts.last_old.valid() && been_here ? std::optional(parts) : std::nullopt;
}

template <class Wanted>
Layout layout(const Graph& graph, const PlaneMap& planes, const Eigen::Quaterniond& level, const Pose& T_base_lidar, int votes, std::size_t fewest,
              const Wanted& wanted) {
  LayoutBuilder builder(level, T_base_lidar);
  for (const auto& [id, record] : planes.records()) {
    const Plane* plane = graph.find(id);
    if (plane == nullptr) continue;
    std::vector<LayoutBuilder::View> views;
    for (const PlaneObservation& seen : record.observations) {
      const Pose* pose = wanted(seen.keyframe) ? graph.find(seen.keyframe) : nullptr;
      if (pose != nullptr) views.push_back({*pose, &seen.outline_base});
    }
    if (!views.empty()) builder.add_plane(id, *plane, views, fewest);
  }
  return builder.build(votes);
}

Eigen::Quaterniond level_of(const Graph& graph, const PlaneMap& planes) {
  Upward up;
  for (const auto& [id, record] : planes.records()) {
    if (const Plane* plane = graph.find(id)) up.add(plane->normal, outline_area(record.outline));
  }
  return up.level();
}

// The largest standard deviation of a translation on the ground.
double ground_sigma(const Matrix6& covariance) { return std::sqrt(std::max(0.0, std::max(covariance(3, 3), covariance(4, 4)))); }

// How uncertain the graph is about the newest keyframe as seen from the first; nothing when it doesn't know.
std::optional<double> graph_sigma(const Marginals& marginals, KeyframeId newest) {
  const auto covariance = marginals.covariance(newest);
  return covariance ? std::optional(ground_sigma(*covariance)) : std::nullopt;
}

// Squared Mahalanobis distance of a candidate from where the graph has it; nothing when the graph doesn't know how sure it is. The graph takes the
// error of each step of the odometry for independent, but wheels that are too large and a gyro that drifts err the same way at each step. The steps
// that nothing but the odometry holds are as many as the variance of the heading holds steps, and were their errors all the same, the variance would
// be so many times as large.
std::optional<double> innovation(const Graph& graph, const Marginals& marginals, const OdometryDrift& drift, const LoopCandidate& candidate) {
  const auto joint = marginals.joint({candidate.from, candidate.to});
  if (!joint) return std::nullopt;
  const Pose expected = graph.find(candidate.from)->inverse() * *graph.find(candidate.to);
  Eigen::Matrix<double, 6, 12> J;
  J << -se3_adjoint(expected.inverse()), Matrix6::Identity();
  const Matrix6 covariance = J * *joint * J.transpose();
  const auto steps = static_cast<double>(candidate.to.value - candidate.from.value);
  const double heading = drift.between(candidate.from, candidate.to)(2, 2) / steps;
  const double alike = heading > 0 ? std::min(std::max(covariance(2, 2) / heading, 1.0), steps) : 1.0;
  const Matrix6 total = alike * covariance + Matrix6(found_sigma().cwiseAbs2().asDiagonal());
  const Vector6 error = se3_log(expected.inverse() * candidate.T_from_to);
  return error.dot(total.ldlt().solve(error));
}

// Whether two candidates tell the same motion between the old part and the new one, by what lies between them in the graph.
bool consistent(const Graph& graph, const OdometryDrift& drift, const LoopCandidate& a, const LoopCandidate& b) {
  const Pose T_old = graph.find(b.from)->inverse() * *graph.find(a.from);
  const Pose T_new = graph.find(a.to)->inverse() * *graph.find(b.to);
  const Pose error = b.T_from_to.inverse() * T_old * a.T_from_to * T_new;
  const Matrix6 between =
      drift.between(std::min(a.to, b.to), std::max(a.to, b.to)) + drift.between(std::min(a.from, b.from), std::max(a.from, b.from));
  const Vector6 own = found_sigma();
  Eigen::Vector3d e(se3_log(error)[2], error.translation.x(), error.translation.y());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  const std::array<int, 3> rows{2, 3, 4};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) covariance(r, c) = between(rows[static_cast<std::size_t>(r)], rows[static_cast<std::size_t>(c)]);
    covariance(r, r) += 2 * own[rows[static_cast<std::size_t>(r)]] * own[rows[static_cast<std::size_t>(r)]];
  }
  return e.dot(covariance.ldlt().solve(e)) < chi_square_3;
}

Se3Between factor_of(const LoopCandidate& candidate) {
  Vector6 tiny;
  tiny.setConstant(1e-6);
  return {candidate.from, candidate.to, candidate.T_from_to,
          SqrtInformation<6>::from_covariance(found_sigma().cwiseAbs2().asDiagonal().toDenseMatrix(), tiny), Se3Between::Source::loop};
}

KeyframeId nearest_old(const Graph& graph, const std::map<KeyframeId, SceneKeyframe>& keyframes, const Parts& parts, const Eigen::Vector3d& at) {
  KeyframeId nearest;
  double least = HUGE_VAL;
  for (const auto& [id, keyframe] : keyframes) {
    if (!parts.is_old(id)) continue;
    const double distance = (graph.find(id)->translation - at).squaredNorm();
    if (distance >= least) continue;
    least = distance;
    nearest = id;
  }
  return nearest;
}

std::string name_of(const LoopCandidate& candidate) {
  return "loop by appearance keyframe/" + std::to_string(candidate.from.value) + " to keyframe/" + std::to_string(candidate.to.value);
}

// The place where the last metres have been seen before, when one place alone agrees with them.
std::optional<LoopCandidate> search(Committer& committer, const LoopCloser& loops, const std::map<KeyframeId, SceneKeyframe>& keyframes,
                                    const PlaneMap& planes, const Parts& parts) {
  const Graph& graph = committer.graph;
  const KeyframeId now = committer.newest();
  const Eigen::Quaterniond level = level_of(graph, planes);
  const Layout query =
      layout(graph, planes, level, loops.T_base_lidar, LayoutBuilder::query_votes, 1, [&](KeyframeId id) { return parts.is_new(id); });
  const PlaceSearch old(layout(graph, planes, level, loops.T_base_lidar, LayoutBuilder::map_votes, LayoutBuilder::least_views,
                               [&](KeyframeId id) { return parts.is_old(id); }));
  const PlaceSearchResult places = old.find(query);
  const PlaceVerdict verdict = judge_places(places, query);
  if (!verdict.stands) return std::nullopt;
  const PlaceHypothesis& best = places.hypotheses.front();
  const Pose T_level{Eigen::Quaterniond(Eigen::AngleAxisd(best.T_map_query.yaw, Eigen::Vector3d::UnitZ())),
                     {best.T_map_query.translation.x(), best.T_map_query.translation.y(), 0}};
  const Pose corrected = turn(level.conjugate()) * T_level * turn(level) * *graph.find(now);
  const KeyframeId from = nearest_old(graph, keyframes, parts, corrected.translation);
  LoopCandidate candidate{from, now, graph.find(from)->inverse() * corrected};
  if (!verdict.believed()) {
    committer.note(
        false, name_of(candidate),
        (verdict.possible > 1 ? std::to_string(verdict.possible) + " places look alike: " : "too little has been seen: ") + to_string(best.fit));
    return std::nullopt;
  }
  return candidate;
}

}  // namespace

bool close_loop_by_appearance(Committer& committer, LoopCloser& loops, const std::map<KeyframeId, SceneKeyframe>& keyframes, const PlaneMap& planes,
                              const OdometryDrift& drift, MarginalsCache& cache) {
  const LoopParams& params = loops.params;
  const Graph& graph = committer.graph;
  const KeyframeId now = committer.newest();
  if (!params.enabled || !params.appearance) return false;
  const double interval = loops.held ? params.min_interval : params.appearance_interval;
  if (loops.last_searched.valid() && drift.path(loops.last_searched, now) < interval) return false;
  // What the odometry alone holds needs no search; this is the cheap question, and the answer for an odometry that registers scans.
  if (ground_sigma(drift.between(keyframes.begin()->first, now)) < params.appearance_sigma) return false;
  const auto parts = parts_of(keyframes, drift, now, params.min_path);
  if (!parts) return false;
  loops.last_searched = now;
  const Marginals* marginals = cache.get(graph, marginals_age);
  const auto sigma = marginals ? graph_sigma(*marginals, cache.newest()) : std::nullopt;
  loops.held = sigma && *sigma < params.appearance_sigma;
  if (loops.held) {
    loops.candidates.clear();
    return false;
  }
  auto& candidates = loops.candidates;
  candidates.erase(
      std::remove_if(candidates.begin(), candidates.end(), [&](const LoopCandidate& c) { return drift.path(c.to, now) > candidate_path; }),
      candidates.end());
  const auto candidate = search(committer, loops, keyframes, planes, *parts);
  if (!candidate) return false;
  const Pose off = graph.find(now)->inverse() * *graph.find(candidate->from) * candidate->T_from_to;
  if (off.translation.head<2>().norm() < agrees && std::abs(se3_log(off)[2]) < agrees_angle) return false;
  std::ostringstream figures;
  figures << std::setprecision(3) << off.translation.head<2>().norm() << " m, " << se3_log(off)[2] * 180 / M_PI << " deg from where the graph has it";
  marginals = cache.get(graph, 0);
  if (!marginals) {  // a wrong loop is worse than a missed one
    committer.note(false, name_of(*candidate), "the graph doesn't know how far off it may be: " + figures.str());
    return false;
  }
  const auto chi_square = innovation(graph, *marginals, drift, *candidate);
  figures << ", chi-square " << chi_square.value_or(HUGE_VAL);
  if (!chi_square || !(*chi_square < chi_square_6)) {
    committer.note(false, name_of(*candidate), "contradicts the graph: " + figures.str());
    return false;
  }
  std::vector<LoopCandidate> agreeing;
  for (const LoopCandidate& other : candidates) {
    if (consistent(graph, drift, other, *candidate)) agreeing.push_back(other);
  }
  candidates.push_back(*candidate);
  agreeing.push_back(*candidate);
  const double span = drift.path(agreeing.front().to, now);
  figures << ", " << agreeing.size() << " searches agree over " << span << " m";
  if (static_cast<int>(agreeing.size()) < params.appearance_views || span < params.appearance_span) {
    committer.note(false, name_of(*candidate), "to be confirmed: " + figures.str());
    return false;
  }
  Transaction edit;
  edit.reason = name_of(*candidate);
  for (const LoopCandidate& each : agreeing) add_factor(edit, factor_of(each));  // they were compared with each other: no robust loss
  candidates.clear();
  committer.note(true, name_of(*candidate), figures.str());
  return committer.commit(edit).ok();
}

}  // namespace sgraph
