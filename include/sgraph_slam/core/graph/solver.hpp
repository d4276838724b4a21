#pragma once

#include <optional>
#include <set>

#include "sgraph_slam/core/graph/graph.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

struct SolverOptions {
  int max_iterations = 30;
  double function_tolerance = 1e-5;   ///< stop when the cost falls by less than this share of itself
  double parameter_tolerance = 1e-8;  ///< stop when the step is shorter than this share of the variables
  int threads = 1;                    ///< the result doesn't depend on it beyond rounding; 1 is reproducible to the bit
};

/// What a solve may move; everything else stays where it is.
struct SolveScope {
  std::optional<std::set<VariableId>> free;  ///< nothing given: all variables
};

/// Optimises the graph's variables in place; the only place that calls ceres::Solve. The first keyframe is held constant (gauge). Values that come
/// out not finite are not written back (`converged` is false then). Deterministic. Not thread-safe on one graph.
SolveSummary solve(Graph& graph, const SolverOptions& options, const SolveScope& scope = {});

/// The newest `count` keyframes, the planes they see, and the rooms and corridors of those planes.
SolveScope recent_window(const Graph& graph, int count);

/// Weighted residual of a factor at the graph's values, without its robust loss. Empty when the graph lacks one of its variables.
Eigen::VectorXd weighted_residual(const Graph& graph, const FactorData& factor);

/// Squared norm of it, to be compared with chi-square of residual_rank(factor) degrees of freedom; infinity when a variable is missing.
double chi_square(const Graph& graph, const FactorData& factor);

/// Sum of all factors' costs, robust losses applied (Ceres' cost: half of the squares).
double total_cost(const Graph& graph);

}  // namespace sgraph
