#include "selected_inverse.hpp"

#include <algorithm>

namespace sgraph {

SelectedInverse::SelectedInverse(const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>& factored) : permuted_(factored.permutationP().indices()) {
  const Eigen::SparseMatrix<double>& L = factored.matrixL().nestedExpression();
  const Eigen::VectorXd D = factored.vectorD();
  const int n = static_cast<int>(L.cols());
  const auto size = static_cast<std::size_t>(n);
  begin_.assign(size + 1, 0);
  diagonal_.assign(size, 0.0);
  std::vector<double> lower;
  for (int j = 0; j < n; ++j) {
    for (Eigen::SparseMatrix<double>::InnerIterator entry(L, j); entry; ++entry) {
      if (entry.row() <= j) continue;  // the unit diagonal, if it is stored
      row_.push_back(static_cast<int>(entry.row()));
      lower.push_back(entry.value());
    }
    begin_[static_cast<std::size_t>(j) + 1] = static_cast<int>(row_.size());
  }
  values_.assign(row_.size(), 0.0);

  // Z = D^-1 L^-1 + Z (1 - L), from the last column to the first: below the diagonal z_j = -Z_SS l_j, with S the rows of column j.
  std::vector<double> l(size, 0.0);
  std::vector<double> z(size, 0.0);
  for (std::size_t j = size; j-- > 0;) {
    const auto first = static_cast<std::size_t>(begin_[j]);
    const auto last = static_cast<std::size_t>(begin_[j + 1]);
    for (std::size_t s = first; s < last; ++s) {
      l[static_cast<std::size_t>(row_[s])] = lower[s];
      z[static_cast<std::size_t>(row_[s])] = 0.0;
    }
    for (std::size_t s = first; s < last; ++s) {
      const auto k = static_cast<std::size_t>(row_[s]);
      const double l_k = l[k];
      double z_k = z[k] - diagonal_[k] * l_k;
      for (auto e = static_cast<std::size_t>(begin_[k]); e < static_cast<std::size_t>(begin_[k + 1]); ++e) {
        const auto i = static_cast<std::size_t>(row_[e]);  // what isn't in S has l = 0, and its z isn't read
        z[i] -= values_[e] * l_k;
        z_k -= values_[e] * l[i];
      }
      z[k] = z_k;
    }
    diagonal_[j] = 1.0 / D[static_cast<Eigen::Index>(j)];
    for (std::size_t s = first; s < last; ++s) {
      const auto k = static_cast<std::size_t>(row_[s]);
      values_[s] = z[k];
      diagonal_[j] -= l[k] * z[k];
      l[k] = 0.0;
    }
  }
}

double SelectedInverse::operator()(Eigen::Index row, Eigen::Index column) const {
  const int a = permuted_[row];
  const int b = permuted_[column];
  if (a == b) return diagonal_[static_cast<std::size_t>(a)];
  const auto j = static_cast<std::size_t>(std::min(a, b));
  const auto entry = std::lower_bound(row_.begin() + begin_[j], row_.begin() + begin_[j + 1], std::max(a, b));
  return values_[static_cast<std::size_t>(entry - row_.begin())];
}

}  // namespace sgraph
