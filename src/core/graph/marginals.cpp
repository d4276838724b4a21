#include "sgraph_slam/core/graph/marginals.hpp"

#include <algorithm>
#include <limits>
#include <map>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>

#include "cost_blocks.hpp"

namespace sgraph {

using Eigen::Index;
using Eigen::MatrixXd;

// H = sum of w J^T J over the factors, all variables but the gauge keyframe; its inverse is the covariance.
class Marginals::Implementation {
 public:
  explicit Implementation(const Graph& graph) {
    Index size = 0;
    const auto take = [&](const VariableId& id) {
      if (graph.factors_of(id).empty()) return;  // unknown altogether
      begin_.emplace(id, size);
      size += tangent_size(id);
    };
    for (const auto& [id, pose] : graph.keyframes()) {
      if (id == graph.keyframes().begin()->first) {
        gauge_ = id;
      } else {
        take(id);
      }
    }
    for (const auto& [id, plane] : graph.planes()) take(id);
    for (const auto& [id, room] : graph.rooms()) take(id);
    for (const auto& [id, corridor] : graph.corridors()) take(id);
    factorize(graph, size);
  }

  [[nodiscard]] bool ok() const { return ok_; }

  std::optional<MatrixXd> joint(const std::vector<VariableId>& ids) {
    if (!ok_) return std::nullopt;
    Index size = 0;
    for (const VariableId& id : ids) {
      if (id != gauge_ && begin_.count(id) == 0) return std::nullopt;
      size += tangent_size(id);
    }
    MatrixXd out = MatrixXd::Zero(size, size);
    Index column = 0;
    for (const VariableId& b : ids) {
      if (b != gauge_) {
        const MatrixXd& of_b = columns(b);
        Index row = 0;
        for (const VariableId& a : ids) {
          if (a != gauge_) out.block(row, column, tangent_size(a), tangent_size(b)) = of_b.middleRows(begin_.at(a), tangent_size(a));
          row += tangent_size(a);
        }
      }
      column += tangent_size(b);
    }
    return 0.5 * (out + out.transpose());
  }

 private:
  void factorize(const Graph& graph, Index size) {
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd residual;
    std::vector<MatrixXd> jacobians;
    for (const auto& [id, factor] : graph.factors()) {
      linearize(graph, factor.data, residual, &jacobians);
      const double weight = loss_weight(factor.loss, residual.squaredNorm());
      const auto ids = blocks(factor.data);
      for (std::size_t i = 0; i < ids.size(); ++i) {
        for (std::size_t j = 0; j < ids.size(); ++j) {
          if (ids[i] == gauge_ || ids[j] == gauge_ || begin_.at(ids[i]) < begin_.at(ids[j])) continue;
          add_block(weight * jacobians[i].transpose() * jacobians[j], begin_.at(ids[i]), begin_.at(ids[j]), entries);
        }
      }
    }
    Eigen::SparseMatrix<double> H(size, size);
    H.setFromTriplets(entries.begin(), entries.end());
    solver_.compute(H);
    const Eigen::VectorXd pivots = solver_.info() == Eigen::Success ? Eigen::VectorXd(solver_.vectorD()) : Eigen::VectorXd();
    // A pivot that has lost all its digits stands for a direction that no factor holds.
    ok_ = size == 0 || (pivots.size() == size && pivots.allFinite() && pivots.minCoeff() > 1e-14 * pivots.maxCoeff());
  }

  static void add_block(const MatrixXd& block, Index row, Index column, std::vector<Eigen::Triplet<double>>& entries) {
    for (Index c = 0; c < block.cols(); ++c) {
      for (Index r = 0; r < block.rows(); ++r) {
        if (row + r >= column + c) entries.emplace_back(static_cast<int>(row + r), static_cast<int>(column + c), block(r, c));
      }
    }
  }

  const MatrixXd& columns(const VariableId& id) {
    const auto found = columns_.find(id);
    if (found != columns_.end()) return found->second;
    MatrixXd unit = MatrixXd::Zero(solver_.rows(), tangent_size(id));
    unit.middleRows(begin_.at(id), tangent_size(id)).setIdentity();
    return columns_.emplace(id, solver_.solve(unit)).first->second;
  }

  VariableId gauge_ = KeyframeId{};
  std::map<VariableId, Index> begin_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver_;
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
  const auto covariance = marginals.joint(ids);
  if (!covariance) return infinity;
  Eigen::VectorXd residual;
  std::vector<MatrixXd> by_block;
  linearize(graph, factor, residual, &by_block);
  MatrixXd jacobian(residual.size(), covariance->rows());
  Index column = 0;
  for (const MatrixXd& j : by_block) {
    jacobian.middleCols(column, j.cols()) = j;
    column += j.cols();
  }
  const MatrixXd S = MatrixXd::Identity(residual.size(), residual.size()) + jacobian * *covariance * jacobian.transpose();
  return residual.dot(S.ldlt().solve(residual));
}

}  // namespace sgraph
