#pragma once

#include <memory>

#include "normal_equations.hpp"

namespace sgraph {

/// Solves `(H + D) x = b` for equations of one pattern, D diagonal.
class LinearSolver {
 public:
  virtual ~LinearSolver() = default;

  /// False when the matrix isn't positive definite. `equations` must outlive the next solve.
  virtual bool factorize(const NormalEquations& equations, const Eigen::VectorXd& damping) = 0;

  /// The solution; the part of `1/2 x^T H x - b^T x` that is left to gain is about `tolerance^2` of what has been gained (direct solvers leave none).
  virtual Eigen::VectorXd solve(const Eigen::VectorXd& b, double tolerance) = 0;

  /// Of the last solve, for reports: 0 for a direct one.
  [[nodiscard]] virtual int iterations() const { return 0; }
};

/// Operations of a sparse Cholesky factorisation of the whole of H with the ordering by least degree, found from the pattern alone.
double factorization_cost(const NormalEquations& pattern);

/// Sparse Cholesky of the whole. Exact; right where variables see few others (pose graphs, small buildings).
std::unique_ptr<LinearSolver> make_direct_solver();

/// Landmarks eliminated (Schur complement), keyframes by conjugate gradients with two levels of preconditioning: exact in groups of consecutive
/// keyframes, and a coarse problem in which longer groups move as rigid bodies. Cost and memory grow with the number of factors only, where the
/// Cholesky factor of a building whose floor is seen from everywhere grows with the square of the keyframes and its cost with the cube.
std::unique_ptr<LinearSolver> make_iterative_solver();

/// Whichever of the two is cheaper.
std::unique_ptr<LinearSolver> make_linear_solver(const NormalEquations& pattern);

}  // namespace sgraph
