#pragma once

#include <map>
#include <utility>
#include <vector>

#include <Eigen/SparseCore>

#include "sgraph_slam/core/graph/graph.hpp"

namespace sgraph {

/// `H = sum over the factors of w J^T J` at the graph's values, in our tangent spaces, with w what a factor's robust loss leaves it. All variables
/// that have factors but the gauge keyframe, in the order of their ids.
class NormalEquations {
 public:
  explicit NormalEquations(const Graph& graph);

  /// Lower triangle.
  [[nodiscard]] Eigen::SparseMatrix<double> matrix() const;
  [[nodiscard]] Eigen::Index size() const { return begin_.empty() ? 0 : begin_.back(); }

  /// First row of a variable; -1 for the gauge keyframe and for what isn't in the equations.
  [[nodiscard]] Eigen::Index row_of(const VariableId& id) const;
  /// Whether a factor joins the two, or they are one.
  [[nodiscard]] bool joined(const VariableId& a, const VariableId& b) const;

 private:
  using Key = std::pair<int, int>;  // block column, block row, row >= column

  void add(const Graph& graph, const Factor& factor);
  [[nodiscard]] int number_of(const VariableId& id) const;
  [[nodiscard]] std::size_t index_of(Key key) const;
  [[nodiscard]] Eigen::Index width(int number) const {
    return begin_[static_cast<std::size_t>(number) + 1] - begin_[static_cast<std::size_t>(number)];
  }

  std::map<VariableId, int> number_;
  std::vector<Eigen::Index> begin_;  // row of each numbered variable, and the size
  std::vector<Key> keys_;            // sorted: the blocks that are not zero
  std::vector<Eigen::Matrix<double, 6, 6>> blocks_;
};

}  // namespace sgraph
