#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "sgraph_slam/core/graph/graph.hpp"

namespace sgraph {

/// How covariances are found: from a sparse factorisation of the whole (exact), from a trajectory that bends at some keyframes only (see Marginals),
/// or exactly where that is cheap and otherwise not.
enum class MarginalsMethod { automatic, exact, coarse };

/// Covariances of the graph's variables around their present values, from one factorisation of the normal equations (robust losses applied as
/// weights). In the tangent spaces of variables.hpp. The first keyframe is known exactly (zero covariance). A picture of the graph at construction:
/// later edits don't show.
///
/// The factorisation of a building in which most planes are seen from everywhere costs the cube of the keyframes. There the trajectory is taken to
/// bend at `most_nodes` keyframes and at each of the newest only, the keyframes between moving with their neighbours among them; planes, rooms and
/// corridors stay variables each. Exact with every keyframe a node; else covariances come out slightly too small, by what the keyframes between could
/// still move (docs/solver.md has figures).
class Marginals {
 public:
  explicit Marginals(const Graph& graph, MarginalsMethod method = MarginalsMethod::automatic, int most_nodes = 100);
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
