#include "sgraph_slam/core/graph/recent_solver.hpp"

#include <algorithm>
#include <chrono>

#include "optimize.hpp"
#include "problem.hpp"

namespace sgraph {
namespace {

// The keyframe of a view of a plane; null for other factors.
const KeyframeId* keyframe_of(const FactorData& data) {
  if (const auto* fitted = std::get_if<PosePlane>(&data)) return &fitted->keyframe;
  if (const auto* points = std::get_if<PosePlanePoints>(&data)) return &points->keyframe;
  return nullptr;
}

PlaneObservation observation_of(const FactorData& data) {
  const auto* fitted = std::get_if<PosePlane>(&data);
  return fitted != nullptr ? PlaneObservation::of(*fitted) : PlaneObservation::of(std::get<PosePlanePoints>(data));
}

Eigen::Vector4d coordinates(const Plane& plane) { return {plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.d}; }

// With the robust weight that the view has at the plane's present value.
void add(FixedViews& views, const Factor& factor, const Pose& T_map_base, const Eigen::Vector4d& plane) {
  const PlaneObservation observation = observation_of(factor.data);
  Eigen::Matrix<double, 3, 4> by_plane;
  by_plane.leftCols<3>() = observation.A.leftCols<3>() * T_map_base.matrix().transpose() + observation.A.col(3) * T_map_base.translation.transpose();
  by_plane.col(3) = observation.A.col(3);
  const double weight = loss_weight(factor.loss, (by_plane * plane - observation.b).squaredNorm());
  const Eigen::Vector3d e = by_plane * views.reference - observation.b;
  views.Q.noalias() += weight * by_plane.transpose() * by_plane;
  views.g.noalias() += weight * by_plane.transpose() * e;
  views.squared += weight * e.squaredNorm();
  ++views.count;
}

}  // namespace

void RecentSolver::update(const Graph& graph, PlaneId id, KeyframeId oldest) {
  const auto [entry, fresh] = seen_.try_emplace(id);
  Seen& seen = entry->second;
  const Eigen::Vector4d plane = coordinates(*graph.find(id));
  if (fresh) seen.views.reference = plane;
  const auto& factors = graph.factors_of(id);
  for (auto factor = factors.upper_bound(seen.last); factor != factors.end(); ++factor) {
    (keyframe_of(graph.find(*factor)->data) != nullptr ? seen.recent : seen.others).push_back(*factor);
    seen.last = *factor;
  }
  const auto settled = std::stable_partition(seen.recent.begin(), seen.recent.end(),
                                             [&](FactorId factor) { return !(*keyframe_of(graph.find(factor)->data) < oldest); });
  for (auto factor = settled; factor != seen.recent.end(); ++factor) {
    const Factor& view = *graph.find(*factor);
    add(seen.views, view, *graph.find(*keyframe_of(view.data)), plane);
  }
  seen.recent.erase(settled, seen.recent.end());
  const auto gone = [&graph](FactorId factor) { return graph.find(factor) == nullptr; };
  seen.others.erase(std::remove_if(seen.others.begin(), seen.others.end(), gone), seen.others.end());
}

SolveSummary RecentSolver::solve(Graph& graph, int count, const SolverOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  if (withdrawn_ != graph.views_withdrawn() || moved_ != graph.keyframes_moved()) seen_.clear();
  SolveScope scope;
  scope.free.emplace();
  std::set<FactorId> factors;
  std::set<PlaneId> planes;
  const auto take = [&](const VariableId& id) {
    const auto& of_variable = graph.factors_of(id);
    factors.insert(of_variable.begin(), of_variable.end());
  };
  KeyframeId oldest;
  auto keyframe = graph.keyframes().rbegin();
  for (int i = 0; i < count && keyframe != graph.keyframes().rend(); ++i, ++keyframe) {
    oldest = keyframe->first;
    scope.free->insert(oldest);
    take(oldest);
  }
  for (const FactorId id : factors) {
    for (const VariableId& variable : blocks(graph.find(id)->data)) {
      if (const auto* plane = std::get_if<PlaneId>(&variable)) planes.insert(*plane);
    }
  }
  std::vector<std::pair<PlaneId, const FixedViews*>> fixed;
  std::set<VariableId> places;
  for (const PlaneId id : planes) {
    update(graph, id, oldest);
    scope.free->insert(id);
    const Seen& seen = seen_.at(id);
    if (seen.views.count > 0) fixed.emplace_back(id, &seen.views);
    factors.insert(seen.others.begin(), seen.others.end());
    for (const FactorId other : seen.others) {
      for (const VariableId& variable : blocks(graph.find(other)->data)) {
        if (std::holds_alternative<RoomId>(variable) || std::holds_alternative<CorridorId>(variable)) places.insert(variable);
      }
    }
  }
  for (const VariableId& place : places) {
    scope.free->insert(place);
    take(place);
  }
  std::vector<const Factor*> terms;
  for (const FactorId id : factors) terms.push_back(graph.find(id));
  Problem problem(graph, scope, terms, fixed);
  SolveSummary summary = optimize(problem, graph, options);
  withdrawn_ = graph.views_withdrawn();
  moved_ = graph.keyframes_moved();
  summary.milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return summary;
}

}  // namespace sgraph
