#include "normal_equations.hpp"

#include <algorithm>

#include "cost_blocks.hpp"

namespace sgraph {

NormalEquations::NormalEquations(const Graph& graph) {
  begin_.push_back(0);
  const auto take = [&](const VariableId& id) {
    if (graph.factors_of(id).empty()) return;
    number_.emplace_hint(number_.end(), id, static_cast<int>(number_.size()));
    begin_.push_back(begin_.back() + tangent_size(id));
  };
  for (const auto& [id, pose] : graph.keyframes()) {
    if (id != graph.keyframes().begin()->first) take(id);
  }
  for (const auto& [id, plane] : graph.planes()) take(id);
  for (const auto& [id, room] : graph.rooms()) take(id);
  for (const auto& [id, corridor] : graph.corridors()) take(id);

  for (const auto& [id, number] : number_) keys_.emplace_back(number, number);
  for (const auto& [id, factor] : graph.factors()) {
    const BlockIds ids = blocks(factor.data);
    if (ids.size() < 2) continue;
    const auto [low, high] = std::minmax({number_of(ids[0]), number_of(ids[1])});
    if (low >= 0) keys_.emplace_back(low, high);
  }
  std::sort(keys_.begin(), keys_.end());
  keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
  blocks_.assign(keys_.size(), Eigen::Matrix<double, 6, 6>::Zero());
  for (const auto& [id, factor] : graph.factors()) add(graph, factor);
}

void NormalEquations::add(const Graph& graph, const Factor& factor) {
  const BlockIds ids = blocks(factor.data);
  const Linearization linear = linearize(graph, factor.data);
  const double weight = loss_weight(factor.loss, linear.residual.squaredNorm());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    for (std::size_t j = 0; j < ids.size(); ++j) {
      const Key key{number_of(ids[j]), number_of(ids[i])};
      if (key.first < 0 || key.second < key.first) continue;
      const SmallMatrix& by_row = linear.jacobians[i];
      const SmallMatrix& by_column = linear.jacobians[j];
      blocks_[index_of(key)].topLeftCorner(by_row.cols(), by_column.cols()) += weight * by_row.transpose().lazyProduct(by_column);
    }
  }
}

Eigen::SparseMatrix<double> NormalEquations::matrix() const {
  Eigen::SparseMatrix<double> H(size(), size());
  Eigen::Index entries = 0;
  for (const auto& [column, row] : keys_) entries += width(column) * width(row);
  H.reserve(entries);
  for (std::size_t first = 0, last = 0; first < keys_.size(); first = last) {
    const int column = keys_[first].first;
    while (last < keys_.size() && keys_[last].first == column) ++last;
    for (Eigen::Index c = 0; c < width(column); ++c) {
      const Eigen::Index j = begin_[static_cast<std::size_t>(column)] + c;
      H.startVec(j);
      for (std::size_t k = first; k < last; ++k) {
        const int row = keys_[k].second;
        for (Eigen::Index r = row == column ? c : 0; r < width(row); ++r) {
          H.insertBack(begin_[static_cast<std::size_t>(row)] + r, j) = blocks_[k](r, c);
        }
      }
    }
  }
  H.finalize();
  return H;
}

int NormalEquations::number_of(const VariableId& id) const {
  const auto found = number_.find(id);
  return found == number_.end() ? -1 : found->second;
}

Eigen::Index NormalEquations::row_of(const VariableId& id) const {
  const int number = number_of(id);
  return number < 0 ? -1 : begin_[static_cast<std::size_t>(number)];
}

std::size_t NormalEquations::index_of(Key key) const {
  return static_cast<std::size_t>(std::lower_bound(keys_.begin(), keys_.end(), key) - keys_.begin());
}

bool NormalEquations::joined(const VariableId& a, const VariableId& b) const {
  const auto [low, high] = std::minmax({number_of(a), number_of(b)});
  return low >= 0 && std::binary_search(keys_.begin(), keys_.end(), Key{low, high});
}

}  // namespace sgraph
