#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/graph/graph.hpp"

namespace sgraph {

/// Covariances of the graph's variables around their present values, from one sparse factorisation of the normal equations (robust losses applied as
/// weights). In the tangent spaces of variables.hpp. The first keyframe is known exactly (zero covariance). A picture of the graph at construction:
/// later edits don't show.
class Marginals {
 public:
  explicit Marginals(const Graph& graph);
  ~Marginals();
  Marginals(Marginals&&) noexcept;
  Marginals& operator=(Marginals&&) noexcept;

  /// False when the factors don't determine all variables; nothing is known then.
  [[nodiscard]] bool ok() const;

  /// Marginal covariance of one variable; nothing when it isn't in the graph. The first question computes all of them.
  [[nodiscard]] std::optional<Eigen::MatrixXd> covariance(const VariableId& id) const;

  /// Joint covariance of several, in the given order. Cheap for variables that factors join; for others it takes a solve a degree of freedom, kept
  /// for later questions: ask with the one that all of them share first.
  [[nodiscard]] std::optional<Eigen::MatrixXd> joint(const std::vector<VariableId>& ids) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// Chi-square of a measurement that isn't in the graph yet, given how well its variables are known: `e^T (I + J Sigma J^T)^-1 e` with the weighted
/// residual e and its Jacobian J. For association and loop gates; residual_rank(factor) degrees of freedom. Infinity when a variable is missing.
double innovation_chi_square(const Graph& graph, const Marginals& marginals, const FactorData& factor);

}  // namespace sgraph
