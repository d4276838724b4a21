#include <algorithm>
#include <vector>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>

#include "linear_solver.hpp"

namespace sgraph {
namespace {

using Eigen::Index;

class DirectSolver final : public LinearSolver {
 public:
  bool factorize(const NormalEquations& equations, const Eigen::VectorXd& damping) override {
    const Eigen::SparseMatrix<double> H = equations.matrix(damping);
    if (!analyzed_) solver_.analyzePattern(H);
    analyzed_ = true;
    solver_.factorize(H);
    return solver_.info() == Eigen::Success;
  }

  Eigen::VectorXd solve(const Eigen::VectorXd& b, double) override { return solver_.solve(b); }

 private:
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> solver_;
  bool analyzed_ = false;
};

// One row and column a variable.
Eigen::SparseMatrix<double> variables_pattern(const NormalEquations& equations) {
  const int keyframes = equations.keyframes();
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&entries](int a, int b) {
    entries.emplace_back(a, b, 1.0);
    entries.emplace_back(b, a, 1.0);
  };
  const int size = keyframes + equations.landmarks();
  for (int i = 0; i < size; ++i) entries.emplace_back(i, i, 1.0);
  for (const auto& [a, b] : equations.between_pairs) add(a, b);
  for (const auto& [p, k] : equations.seen_pairs) add(keyframes + p, k);
  for (const auto& [a, b] : equations.coupled_pairs) add(keyframes + a, keyframes + b);
  Eigen::SparseMatrix<double> pattern(size, size);
  pattern.setFromTriplets(entries.begin(), entries.end());
  return pattern;
}

}  // namespace

double factorization_cost(const NormalEquations& equations) {
  const Eigen::SparseMatrix<double> pattern = variables_pattern(equations);
  const int size = static_cast<int>(pattern.cols());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> inverse;
  Eigen::AMDOrdering<int>()(pattern, inverse);
  Eigen::SparseMatrix<double> ordered(size, size);
  ordered = pattern.twistedBy(inverse.inverse());
  const auto width = [&](int i) {
    const int original = inverse.indices()[i];
    return static_cast<double>(original < equations.keyframes() ? 6 : equations.width(original - equations.keyframes()));
  };
  // Rows of each column of the factor, by walking up the elimination tree from each entry (Liu 1990).
  std::vector<int> parent(static_cast<std::size_t>(size), -1);
  std::vector<int> flag(static_cast<std::size_t>(size), -1);
  std::vector<double> below(static_cast<std::size_t>(size), 0.0);
  for (int k = 0; k < size; ++k) {
    flag[static_cast<std::size_t>(k)] = k;
    for (Eigen::SparseMatrix<double>::InnerIterator entry(ordered, k); entry && entry.row() < k; ++entry) {
      for (auto i = static_cast<std::size_t>(entry.row()); flag[i] != k; i = static_cast<std::size_t>(parent[i])) {
        if (parent[i] < 0) parent[i] = k;
        below[i] += width(k);
        flag[i] = k;
      }
    }
  }
  double cost = 0;
  for (int k = 0; k < size; ++k) {
    const double rows = below[static_cast<std::size_t>(k)] + width(k);
    cost += width(k) * rows * rows;
  }
  return cost;
}

std::unique_ptr<LinearSolver> make_direct_solver() { return std::make_unique<DirectSolver>(); }

}  // namespace sgraph
