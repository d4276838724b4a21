#include <algorithm>
#include <map>
#include <optional>

#include <Eigen/SparseCholesky>

#include "covariances.hpp"
#include "selected_inverse.hpp"

namespace sgraph {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// A pivot that has lost all its digits stands for a direction that no factor holds.
constexpr double smallest_pivot = 1e-14;

class ExactCovariances final : public Covariances {
 public:
  explicit ExactCovariances(const NormalEquations& equations) : equations_(equations) {
    solver_.compute(equations.matrix(Eigen::VectorXd::Zero(equations.size())));
    if (solver_.info() != Eigen::Success) return;
    const Eigen::VectorXd pivots = solver_.vectorD();
    ok_ = pivots.allFinite() && pivots.minCoeff() > smallest_pivot * pivots.maxCoeff();
  }

  [[nodiscard]] bool ok() const override { return ok_; }

  MatrixXd block(int a, int b) override {
    const Index row = equations_.row(a);
    const Index column = equations_.row(b);
    const Index rows = equations_.degrees(a);
    const Index columns = equations_.degrees(b);
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

 private:
  // The variable's columns of the covariance, solved for once.
  const MatrixXd& columns_of(int variable) {
    const auto found = columns_.find(variable);
    if (found != columns_.end()) return found->second;
    MatrixXd unit = MatrixXd::Zero(equations_.size(), equations_.degrees(variable));
    unit.middleRows(equations_.row(variable), equations_.degrees(variable)).setIdentity();
    return columns_.emplace(variable, solver_.solve(unit)).first->second;
  }

  const NormalEquations& equations_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
  std::optional<SelectedInverse> selected_;  // made when first asked for
  std::map<int, MatrixXd> columns_;
  bool ok_ = false;
};

}  // namespace

std::unique_ptr<Covariances> make_exact_covariances(const NormalEquations& equations) { return std::make_unique<ExactCovariances>(equations); }

}  // namespace sgraph
