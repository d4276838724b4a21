#include "sgraph_slam/core/graph/solver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

#include "cost_blocks.hpp"
#include "optimize.hpp"
#include "problem.hpp"

namespace sgraph {
namespace {

bool has_all(const Graph& graph, const FactorData& factor) {
  const auto ids = blocks(factor);
  return std::all_of(ids.begin(), ids.end(), [&graph](const VariableId& id) { return graph.contains(id); });
}

}  // namespace

SolveSummary solve(Graph& graph, const SolverOptions& options, const SolveScope& scope) {
  const auto start = std::chrono::steady_clock::now();
  Problem problem(graph, scope);
  SolveSummary summary = optimize(problem, graph, options);
  summary.milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return summary;
}

SolveScope recent_window(const Graph& graph, int count) {
  std::set<VariableId> free;
  auto keyframe = graph.keyframes().rbegin();
  for (int i = 0; i < count && keyframe != graph.keyframes().rend(); ++i, ++keyframe) free.insert(keyframe->first);
  const auto take_neighbours = [&](auto wanted) {
    const std::set<VariableId> from = free;
    for (const VariableId& id : from) {
      for (const FactorId factor : graph.factors_of(id)) {
        for (const VariableId& other : blocks(graph.find(factor)->data)) {
          if (wanted(other)) free.insert(other);
        }
      }
    }
  };
  take_neighbours([](const VariableId& id) { return std::holds_alternative<PlaneId>(id); });
  take_neighbours([](const VariableId& id) { return std::holds_alternative<RoomId>(id) || std::holds_alternative<CorridorId>(id); });
  return {free};
}

Eigen::VectorXd weighted_residual(const Graph& graph, const FactorData& factor) {
  if (!has_all(graph, factor)) return {};
  return residual_of(graph, factor);
}

double chi_square(const Graph& graph, const FactorData& factor) {
  const Eigen::VectorXd residual = weighted_residual(graph, factor);
  return residual.size() == 0 ? std::numeric_limits<double>::infinity() : residual.squaredNorm();
}

double total_cost(const Graph& graph) {
  double cost = 0;
  for (const auto& [id, factor] : graph.factors()) {
    const double squared_norm = chi_square(graph, factor.data);
    cost += 0.5 * loss_value(factor.loss, squared_norm);
  }
  return cost;
}

}  // namespace sgraph
