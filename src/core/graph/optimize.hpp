#pragma once

#include "problem.hpp"

namespace sgraph {

/// What a problem's minimisation gave; times are left out.
struct Optimized {
  Problem::Values values;
  SolveSummary summary;
};

/// Minimises the cost by Levenberg-Marquardt steps from the problem's start. Touches no graph.
Optimized optimize(Problem& problem, const SolverOptions& options);

/// The same, and writes the free variables back, all or, when one isn't finite, none (`converged` is false then).
SolveSummary optimize(Problem& problem, Graph& graph, const SolverOptions& options);

}  // namespace sgraph
