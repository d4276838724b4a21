#include "optimize.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "linear_solver.hpp"

namespace sgraph {
namespace {

// Levenberg-Marquardt's trust region (Nielsen 1999), with the constants of Ceres.
constexpr double first_radius = 1e4;
constexpr double largest_radius = 1e16;
constexpr double smallest_radius = 1e-32;
constexpr double least_gain = 1e-3;      // share of the promised gain with which a step is taken
constexpr double least_diagonal = 1e-6;  // of H, for the damping of directions that nothing holds
constexpr double gradient_tolerance = 1e-10;

std::unique_ptr<LinearSolver> solver_for(StepSolver steps, const NormalEquations& equations) {
  switch (steps) {
    case StepSolver::direct: return make_direct_solver();
    case StepSolver::iterative: return make_iterative_solver();
    case StepSolver::automatic: break;
  }
  return make_linear_solver(equations);
}

// One optimisation: its values, its equations and how far it trusts them.
class Optimization {
 public:
  Optimization(Problem& problem, const SolverOptions& options)
      : problem_(problem),
        options_(options),
        values_(problem.start()),
        equations_(problem.pattern()),
        solver_(solver_for(options.steps, equations_)) {
    cost_ = problem_.linearize(values_, equations_);
  }

  [[nodiscard]] double cost() const { return cost_; }
  [[nodiscard]] int iterations() const { return iterations_; }
  [[nodiscard]] const Problem::Values& values() const { return values_; }

  /// True when a minimum has been reached.
  bool run() {
    while (iterations_ < options_.max_iterations) {
      if (equations_.gradient.lpNorm<Eigen::Infinity>() <= gradient_tolerance) return true;
      ++iterations_;
      const Eigen::VectorXd damping = equations_.diagonal().cwiseMax(least_diagonal) / radius_;
      if (!solver_->factorize(equations_, damping)) {
        if (!shrink()) return false;
        continue;
      }
      const Eigen::VectorXd step = solver_->solve(-equations_.gradient, std::sqrt(options_.function_tolerance));
      if (!step.allFinite()) {
        if (!shrink()) return false;
        continue;
      }
      if (is_short(step)) return true;
      const double promised = -equations_.gradient.dot(step) - 0.5 * step.dot(equations_.times(step));
      const Problem::Values next = problem_.moved(values_, step);
      const double cost = problem_.cost(next);
      const double gain = cost_ - cost;
      if (!(promised > 0) || !std::isfinite(cost) || gain < least_gain * promised) {
        // At the minimum rounding hides the gain; a step that promises nothing more is the last one.
        if (promised <= options_.function_tolerance * cost_ && std::abs(gain) <= options_.function_tolerance * cost_) return true;
        if (!shrink()) return false;
        continue;
      }
      const double before = cost_;
      values_ = next;
      const double ratio = gain / promised;
      radius_ = std::min(largest_radius, radius_ / std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * ratio - 1.0, 3)));
      decrease_ = 2.0;
      if (gain <= options_.function_tolerance * before) {
        cost_ = cost;
        return true;
      }
      cost_ = problem_.linearize(values_, equations_);
    }
    return false;
  }

 private:
  bool shrink() {
    radius_ /= decrease_;
    decrease_ *= 2.0;
    return radius_ > smallest_radius;
  }

  [[nodiscard]] bool is_short(const Eigen::VectorXd& step) const {
    double squared = 0;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      if (problem_.variables()[i].number < 0) continue;
      for (const double x : values_[i]) squared += x * x;
    }
    return step.norm() <= options_.parameter_tolerance * (std::sqrt(squared) + options_.parameter_tolerance);
  }

  Problem& problem_;
  const SolverOptions& options_;
  Problem::Values values_;
  NormalEquations equations_;
  std::unique_ptr<LinearSolver> solver_;
  double cost_ = 0;
  double radius_ = first_radius;
  double decrease_ = 2.0;
  int iterations_ = 0;
};

// Writes the free variables back, all or none.
bool write_back(const Problem& problem, const Problem::Values& values, Graph& graph) {
  for (const Block& block : values) {
    if (!std::all_of(block.begin(), block.end(), [](double v) { return std::isfinite(v); })) return false;
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (problem.variables()[i].number >= 0) set_from_block(graph, problem.variables()[i].id, values[i]);
  }
  return true;
}

}  // namespace

Optimized optimize(Problem& problem, const SolverOptions& options) {
  Optimized out;
  SolveSummary& summary = out.summary;
  summary.factors = problem.factors();
  summary.keyframes = problem.free_keyframes();
  summary.planes = problem.free_planes();
  if (summary.factors == 0) {
    out.values = problem.start();
    summary.converged = true;
    return out;
  }
  Optimization optimization(problem, options);
  summary.initial_cost = optimization.cost();
  summary.converged = optimization.run();
  summary.iterations = optimization.iterations();
  summary.final_cost = optimization.cost();
  out.values = optimization.values();
  return out;
}

SolveSummary optimize(Problem& problem, Graph& graph, const SolverOptions& options) {
  Optimized out = optimize(problem, options);
  if (!write_back(problem, out.values, graph)) {
    out.summary.converged = false;
    out.summary.final_cost = out.summary.initial_cost;
  }
  return out.summary;
}

}  // namespace sgraph
