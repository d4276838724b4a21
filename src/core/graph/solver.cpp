#include "sgraph_slam/core/graph/solver.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include <ceres/ceres.h>

#include "cost_blocks.hpp"

namespace sgraph {
namespace {

using PoseManifold = ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>>;
using PlaneManifold = ceres::ProductManifold<ceres::SphereManifold<3>, ceres::EuclideanManifold<1>>;

struct Variable {
  Block block;
  bool constant;
};

// A Ceres problem over some of a graph's variables, with its own copy of their values.
class ScopedProblem {
 public:
  ScopedProblem(const Graph& graph, const SolveScope& scope) : graph_(graph), scope_(scope), problem_(options()) {
    if (!scope.free) {
      for (const auto& [id, factor] : graph.factors()) add(factor);
      return;
    }
    std::vector<FactorId> ids;
    for (const VariableId& id : *scope.free) {
      if (!is_free(id)) continue;
      const auto& of_variable = graph.factors_of(id);
      ids.insert(ids.end(), of_variable.begin(), of_variable.end());
    }
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    for (const FactorId id : ids) add(*graph.find(id));
  }

  ceres::Problem& problem() { return problem_; }
  [[nodiscard]] const std::map<VariableId, Variable>& variables() const { return variables_; }

 private:
  static ceres::Problem::Options options() {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.disable_all_safety_checks = true;  // the store has checked what Ceres would
    return options;
  }

  [[nodiscard]] bool is_free(const VariableId& id) const {
    if (const auto* keyframe = std::get_if<KeyframeId>(&id)) {
      if (*keyframe == graph_.keyframes().begin()->first) return false;  // gauge
    }
    return !scope_.free || scope_.free->count(id) > 0;
  }

  void add(const Factor& factor) {
    const BlockIds ids = blocks(factor.data);
    if (std::none_of(ids.begin(), ids.end(), [this](const VariableId& id) { return is_free(id); })) return;
    std::array<double*, 2> x{};
    for (std::size_t i = 0; i < ids.size(); ++i) {
      auto variable = variables_.find(ids[i]);
      if (variable == variables_.end()) variable = add_block(ids[i]);
      x[i] = variable->second.block.data();
    }
    problem_.AddResidualBlock(make_cost(factor.data, graph_).release(), make_loss(factor.loss).release(), x.data(), static_cast<int>(ids.size()));
  }

  std::map<VariableId, Variable>::iterator add_block(const VariableId& id) {
    ceres::Manifold* manifold = nullptr;
    if (std::holds_alternative<KeyframeId>(id)) manifold = &pose_manifold_;
    if (std::holds_alternative<PlaneId>(id)) manifold = &plane_manifold_;
    const auto added = variables_.emplace(id, Variable{block_of(graph_, id), !is_free(id)}).first;
    double* x = added->second.block.data();
    problem_.AddParameterBlock(x, block_size(id), manifold);
    if (added->second.constant) problem_.SetParameterBlockConstant(x);
    return added;
  }

  PoseManifold pose_manifold_;
  PlaneManifold plane_manifold_;
  const Graph& graph_;
  const SolveScope& scope_;
  std::map<VariableId, Variable> variables_;
  ceres::Problem problem_;
};

// Writes the free variables back, all or none.
bool write_back(const std::map<VariableId, Variable>& variables, Graph& graph) {
  for (const auto& [id, variable] : variables) {
    const auto& block = variable.block;
    if (!std::all_of(block.begin(), block.end(), [](double v) { return std::isfinite(v); })) return false;
  }
  for (const auto& [id, variable] : variables) {
    if (!variable.constant) set_from_block(graph, id, variable.block);
  }
  return true;
}

ceres::Solver::Options ceres_options(const SolverOptions& options) {
  ceres::Solver::Options out;
  out.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  out.max_num_iterations = options.max_iterations;
  out.function_tolerance = options.function_tolerance;
  out.parameter_tolerance = options.parameter_tolerance;
  out.num_threads = options.threads;
  out.logging_type = ceres::SILENT;
  out.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;  // SuiteSparse starts threads of its own, whose number reaches the rounding
  return out;
}

bool has_all(const Graph& graph, const FactorData& factor) {
  const auto ids = blocks(factor);
  return std::all_of(ids.begin(), ids.end(), [&graph](const VariableId& id) { return graph.contains(id); });
}

}  // namespace

SolveSummary solve(Graph& graph, const SolverOptions& options, const SolveScope& scope) {
  const auto start = std::chrono::steady_clock::now();
  ScopedProblem scoped(graph, scope);
  SolveSummary summary;
  summary.factors = scoped.problem().NumResidualBlocks();
  for (const auto& [id, variable] : scoped.variables()) {
    if (variable.constant) continue;
    summary.keyframes += std::holds_alternative<KeyframeId>(id) ? 1 : 0;
    summary.planes += std::holds_alternative<PlaneId>(id) ? 1 : 0;
  }
  if (summary.factors > 0) {
    ceres::Solver::Summary report;
    ceres::Solve(ceres_options(options), &scoped.problem(), &report);
    summary.iterations = static_cast<int>(report.iterations.size()) - 1;
    summary.initial_cost = report.initial_cost;
    summary.final_cost = report.final_cost;
    summary.converged = report.termination_type == ceres::CONVERGENCE;
    if (!report.IsSolutionUsable() || !write_back(scoped.variables(), graph)) {
      summary.converged = false;
      summary.final_cost = report.initial_cost;
    }
  } else {
    summary.converged = true;
  }
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
    double rho[3] = {squared_norm, 1.0, 0.0};
    if (const auto loss = make_loss(factor.loss)) loss->Evaluate(squared_norm, rho);
    cost += 0.5 * rho[0];
  }
  return cost;
}

}  // namespace sgraph
