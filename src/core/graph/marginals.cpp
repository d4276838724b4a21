#include "sgraph_slam/core/graph/marginals.hpp"

#include <algorithm>
#include <limits>

#include <Eigen/Dense>

#include "covariances.hpp"
#include "linear_solver.hpp"
#include "problem.hpp"

namespace sgraph {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

constexpr double exact_cost = 2e7;  // operations: the exact factorisation and what is asked of it take some tens of milliseconds with this many

}  // namespace

class Marginals::Implementation {
 public:
  Implementation(const Graph& graph, MarginalsMethod method, int most_nodes) : problem_(graph, {}), equations_(problem_.pattern()) {
    if (!graph.keyframes().empty()) gauge_ = graph.keyframes().begin()->first;
    if (equations_.size() == 0) return;
    problem_.linearize(problem_.start(), equations_);
    const bool exact = method == MarginalsMethod::exact || (method == MarginalsMethod::automatic && factorization_cost(equations_) <= exact_cost);
    covariances_ = exact ? make_exact_covariances(equations_) : make_coarse_covariances(equations_, most_nodes);
  }

  [[nodiscard]] bool ok() const { return !covariances_ || covariances_->ok(); }

  std::optional<MatrixXd> joint(const std::vector<VariableId>& ids) {
    if (!ok()) return std::nullopt;
    Index size = 0;
    for (const VariableId& id : ids) {
      if (id != gauge_ && number_of(id) < 0) return std::nullopt;
      size += tangent_size(id);
    }
    MatrixXd out = MatrixXd::Zero(size, size);
    for (Index a = 0, row = 0; a < static_cast<Index>(ids.size()); ++a) {
      const VariableId& id_a = ids[static_cast<std::size_t>(a)];
      for (Index b = 0, column = 0; b <= a; ++b) {
        const VariableId& id_b = ids[static_cast<std::size_t>(b)];
        if (id_a != gauge_ && id_b != gauge_) {
          const MatrixXd part = covariances_->block(number_of(id_a), number_of(id_b));
          out.block(row, column, part.rows(), part.cols()) = part;
          if (a != b) out.block(column, row, part.cols(), part.rows()) = part.transpose();
        }
        column += tangent_size(id_b);
      }
      row += tangent_size(id_a);
    }
    return out;
  }

 private:
  // In the equations; -1 for what isn't in them.
  [[nodiscard]] int number_of(const VariableId& id) const {
    const Problem::Variable* variable = problem_.find(id);
    if (variable == nullptr || variable->number < 0) return -1;
    return variable->number + (std::holds_alternative<KeyframeId>(id) ? 0 : equations_.keyframes());
  }

  VariableId gauge_ = KeyframeId{};
  Problem problem_;
  NormalEquations equations_;
  std::unique_ptr<Covariances> covariances_;  // null when there is nothing to know
};

Marginals::Marginals(const Graph& graph, MarginalsMethod method, int most_nodes)
    : implementation_(std::make_unique<Implementation>(graph, method, most_nodes)) {}
Marginals::~Marginals() = default;
Marginals::Marginals(Marginals&&) noexcept = default;
Marginals& Marginals::operator=(Marginals&&) noexcept = default;

bool Marginals::ok() const { return implementation_->ok(); }
std::optional<MatrixXd> Marginals::covariance(const VariableId& id) const { return implementation_->joint({id}); }
std::optional<MatrixXd> Marginals::joint(const std::vector<VariableId>& ids) const { return implementation_->joint(ids); }

double innovation_chi_square(const Graph& graph, const Marginals& marginals, const FactorData& factor) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto ids = blocks(factor);
  if (!std::all_of(ids.begin(), ids.end(), [&graph](const VariableId& id) { return graph.contains(id); })) return infinity;
  const auto covariance = marginals.joint({ids.begin(), ids.end()});
  if (!covariance) return infinity;
  const Linearization linear = linearize(graph, factor);
  MatrixXd jacobian(linear.residual.size(), covariance->rows());
  for (std::size_t i = 0, column = 0; i < ids.size(); ++i) {
    const SmallMatrix& j = linear.jacobians[i];
    jacobian.middleCols(static_cast<Index>(column), j.cols()) = j;
    column += static_cast<std::size_t>(j.cols());
  }
  const MatrixXd S = MatrixXd::Identity(jacobian.rows(), jacobian.rows()) + jacobian * *covariance * jacobian.transpose();
  return linear.residual.dot(S.ldlt().solve(linear.residual));
}

}  // namespace sgraph
