#include "sgraph_slam/core/graph/marginals.hpp"

#include <algorithm>
#include <limits>
#include <map>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

#include "cost_blocks.hpp"
#include "normal_equations.hpp"
#include "selected_inverse.hpp"

namespace sgraph {

using Eigen::Index;
using Eigen::MatrixXd;

class Marginals::Implementation {
 public:
  explicit Implementation(const Graph& graph) : equations_(graph) {
    if (!graph.keyframes().empty()) gauge_ = graph.keyframes().begin()->first;
    if (equations_.size() == 0) {
      ok_ = true;
      return;
    }
    solver_.compute(equations_.matrix());
    if (solver_.info() != Eigen::Success) return;
    // A pivot that has lost all its digits stands for a direction that no factor holds.
    const Eigen::VectorXd pivots = solver_.vectorD();
    ok_ = pivots.allFinite() && pivots.minCoeff() > 1e-14 * pivots.maxCoeff();
  }

  [[nodiscard]] bool ok() const { return ok_; }

  std::optional<MatrixXd> joint(const std::vector<VariableId>& ids) {
    if (!ok_) return std::nullopt;
    Index size = 0;
    for (const VariableId& id : ids) {
      if (id != gauge_ && equations_.row_of(id) < 0) return std::nullopt;
      size += tangent_size(id);
    }
    MatrixXd out = MatrixXd::Zero(size, size);
    for (Index a = 0, row = 0; a < static_cast<Index>(ids.size()); ++a) {
      const VariableId& id_a = ids[static_cast<std::size_t>(a)];
      for (Index b = 0, column = 0; b <= a; ++b) {
        const VariableId& id_b = ids[static_cast<std::size_t>(b)];
        const MatrixXd part = cross(id_a, id_b);
        out.block(row, column, part.rows(), part.cols()) = part;
        if (a != b) out.block(column, row, part.cols(), part.rows()) = part.transpose();
        column += tangent_size(id_b);
      }
      row += tangent_size(id_a);
    }
    return out;
  }

 private:
  MatrixXd cross(const VariableId& a, const VariableId& b) {
    const Index rows = tangent_size(a);
    const Index columns = tangent_size(b);
    if (a == gauge_ || b == gauge_) return MatrixXd::Zero(rows, columns);
    const Index row = equations_.row_of(a);
    const Index column = equations_.row_of(b);
    if (!equations_.joined(a, b)) {
      if (columns_.count(a) > 0) return columns_.at(a).middleRows(column, columns).transpose();
      return columns_of(b).middleRows(row, rows);
    }
    if (!selected_) selected_.emplace(solver_);
    MatrixXd out(rows, columns);
    for (Index c = 0; c < columns; ++c) {
      for (Index r = 0; r < rows; ++r) out(r, c) = (*selected_)(row + r, column + c);
    }
    return out;
  }

  // The variable's columns of the covariance, solved for once.
  const MatrixXd& columns_of(const VariableId& id) {
    const auto found = columns_.find(id);
    if (found != columns_.end()) return found->second;
    MatrixXd unit = MatrixXd::Zero(equations_.size(), tangent_size(id));
    unit.middleRows(equations_.row_of(id), tangent_size(id)).setIdentity();
    return columns_.emplace(id, solver_.solve(unit)).first->second;
  }

  VariableId gauge_ = KeyframeId{};
  NormalEquations equations_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
  std::optional<SelectedInverse> selected_;  // made when first asked for
  std::map<VariableId, MatrixXd> columns_;
  bool ok_ = false;
};

Marginals::Marginals(const Graph& graph) : implementation_(std::make_unique<Implementation>(graph)) {}
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
