#pragma once

#include <optional>
#include <set>

#include "sgraph_slam/core/graph/graph.hpp"
#include "sgraph_slam/core/types/scene.hpp"

namespace sgraph {

/// How a step is found: by a sparse Cholesky factorisation, by conjugate gradients on the keyframes, or by whichever is cheaper for the graph.
enum class StepSolver { automatic, direct, iterative };

struct SolverOptions {
  int max_iterations = 30;
  double function_tolerance = 1e-5;   ///< stop when the cost falls by less than this share of itself
  double parameter_tolerance = 1e-8;  ///< stop when the step is shorter than this share of the variables
  StepSolver steps = StepSolver::automatic;
};

/// What a solve may move; everything else stays where it is.
struct SolveScope {
  std::optional<std::set<VariableId>> free;  ///< nothing given: all variables
};

/// Optimises the graph's variables in place by Levenberg-Marquardt steps. The first keyframe is held constant (gauge). Steps are exact where the
/// equations' Cholesky factor stays sparse; otherwise landmarks are eliminated and the keyframes found by preconditioned conjugate gradients, to what
/// `function_tolerance` asks for (docs/solver.md). Values that come out not finite are not written back (`converged` is false then). Deterministic,
/// on one thread. Not thread-safe on one graph.
SolveSummary solve(Graph& graph, const SolverOptions& options, const SolveScope& scope = {});

/// The newest `count` keyframes, the planes they see, and the rooms and corridors of those planes.
SolveScope recent_window(const Graph& graph, int count);

/// Weighted residual of a factor at the graph's values, without its robust loss. Empty when the graph lacks one of its variables.
Eigen::VectorXd weighted_residual(const Graph& graph, const FactorData& factor);

/// Squared norm of it, to be compared with chi-square of residual_rank(factor) degrees of freedom; infinity when a variable is missing.
double chi_square(const Graph& graph, const FactorData& factor);

/// Sum of all factors' costs, robust losses applied: half of the squares.
double total_cost(const Graph& graph);

}  // namespace sgraph
