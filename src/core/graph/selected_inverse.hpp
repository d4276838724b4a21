#pragma once

#include <vector>

#include <Eigen/SparseCholesky>

namespace sgraph {

/// Entries of the inverse of a sparse symmetric matrix where its factor has entries, so also where the matrix has: all the covariances of neighbours
/// for about twice the cost of the factorisation, where solving for columns costs a solve each (Takahashi, Fagan and Chin 1973; Erisman and Tinney
/// 1975).
class SelectedInverse {
 public:
  /// A successful factorisation.
  explicit SelectedInverse(const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>& factored);

  /// Entry of the inverse in the matrix' own order of rows; both must be joined in the factor.
  [[nodiscard]] double operator()(Eigen::Index row, Eigen::Index column) const;

 private:
  std::vector<int> begin_;  // of each column in row_, values_; below the diagonal
  std::vector<int> row_;
  std::vector<double> values_;
  std::vector<double> diagonal_;
  Eigen::VectorXi permuted_;
};

}  // namespace sgraph
