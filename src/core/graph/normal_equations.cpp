#include "normal_equations.hpp"

#include <algorithm>
#include <tuple>

namespace sgraph {
namespace {

using Eigen::Index;

void sort_once(std::vector<NormalEquations::Pair>& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

// A block below the diagonal or on it, by where it stands.
struct Placed {
  Index column;
  Index row;
  Index columns;
  Index rows;
  const double* values;  // column-major with this stride, or row-major when transposed
  Index stride;
  bool transposed;
};

Eigen::SparseMatrix<double> lower_triangle(Index size, std::vector<Placed>& blocks, const Eigen::VectorXd& damping) {
  std::sort(blocks.begin(), blocks.end(), [](const Placed& a, const Placed& b) { return std::tie(a.column, a.row) < std::tie(b.column, b.row); });
  Eigen::SparseMatrix<double> H(size, size);
  Index entries = 0;
  for (const Placed& block : blocks) entries += block.columns * block.rows;
  H.reserve(entries);
  for (std::size_t first = 0, last = 0; first < blocks.size(); first = last) {
    while (last < blocks.size() && blocks[last].column == blocks[first].column) ++last;
    for (Index c = 0; c < blocks[first].columns; ++c) {
      const Index j = blocks[first].column + c;
      H.startVec(j);
      for (std::size_t k = first; k < last; ++k) {
        const Placed& block = blocks[k];
        const bool diagonal = block.row == block.column;
        for (Index r = diagonal ? c : 0; r < block.rows; ++r) {
          const double value = block.values[block.transposed ? r * block.stride + c : c * block.stride + r];
          H.insertBack(block.row + r, j) = diagonal && r == c ? value + damping[j] : value;
        }
      }
    }
  }
  H.finalize();
  return H;
}

}  // namespace

NormalEquations::NormalEquations(int keyframes, std::vector<int> landmark_widths, std::vector<Pair> between_in, std::vector<Pair> seen_in,
                                 std::vector<Pair> coupled_in)
    : between_pairs(std::move(between_in)), seen_pairs(std::move(seen_in)), coupled_pairs(std::move(coupled_in)) {
  sort_once(between_pairs);
  sort_once(seen_pairs);
  sort_once(coupled_pairs);
  begin_.reserve(landmark_widths.size() + 1);
  begin_.push_back(0);
  for (const int w : landmark_widths) begin_.push_back(begin_.back() + w);
  keyframe.resize(static_cast<std::size_t>(keyframes));
  poses.resize(keyframe.size());
  between.resize(between_pairs.size());
  seen.resize(seen_pairs.size());
  landmark.resize(landmark_widths.size());
  coupled.resize(coupled_pairs.size());
  set_zero();
}

void NormalEquations::set_zero() {
  const auto clear = [](auto& blocks) {
    for (auto& block : blocks) block.setZero();
  };
  clear(keyframe);
  clear(between);
  clear(seen);
  clear(landmark);
  clear(coupled);
  gradient.setZero(size());
}

Index NormalEquations::row(int variable) const {
  return variable < keyframes() ? 6 * static_cast<Index>(variable) : keyframe_size() + begin(variable - keyframes());
}

bool NormalEquations::joined(int a, int b) const {
  if (a == b) return true;
  const auto [low, high] = std::minmax({a, b});
  const int k = keyframes();
  if (high < k) return std::binary_search(between_pairs.begin(), between_pairs.end(), Pair(low, high));
  if (low < k) return std::binary_search(seen_pairs.begin(), seen_pairs.end(), Pair(high - k, low));
  return std::binary_search(coupled_pairs.begin(), coupled_pairs.end(), Pair(low - k, high - k));
}

std::size_t NormalEquations::at(const std::vector<Pair>& pairs, Pair pair) {
  return static_cast<std::size_t>(std::lower_bound(pairs.begin(), pairs.end(), pair) - pairs.begin());
}

Eigen::SparseMatrix<double> NormalEquations::matrix(const Eigen::VectorXd& damping) const {
  std::vector<Placed> blocks;
  blocks.reserve(keyframe.size() + between.size() + seen.size() + landmark.size() + coupled.size());
  for (std::size_t k = 0; k < keyframe.size(); ++k) {
    const Index row = 6 * static_cast<Index>(k);
    blocks.push_back({row, row, 6, 6, keyframe[k].data(), 6, false});
  }
  for (std::size_t i = 0; i < between.size(); ++i) {
    blocks.push_back({6 * between_pairs[i].first, 6 * between_pairs[i].second, 6, 6, between[i].data(), 6, true});
  }
  const Index offset = keyframe_size();
  for (std::size_t i = 0; i < seen.size(); ++i) {
    blocks.push_back({6 * seen_pairs[i].second, offset + begin(seen_pairs[i].first), 6, 3, seen[i].data(), 6, true});
  }
  for (int l = 0; l < landmarks(); ++l) {
    const Index row = offset + begin(l);
    blocks.push_back({row, row, width(l), width(l), landmark[static_cast<std::size_t>(l)].data(), 4, false});
  }
  for (std::size_t i = 0; i < coupled.size(); ++i) {
    const auto [a, b] = coupled_pairs[i];
    blocks.push_back({offset + begin(a), offset + begin(b), width(a), width(b), coupled[i].data(), 4, true});
  }
  return lower_triangle(size(), blocks, damping);
}

Eigen::SparseMatrix<double> NormalEquations::landmark_matrix(const Eigen::VectorXd& landmark_damping) const {
  std::vector<Placed> blocks;
  for (int l = 0; l < landmarks(); ++l) {
    blocks.push_back({begin(l), begin(l), width(l), width(l), landmark[static_cast<std::size_t>(l)].data(), 4, false});
  }
  for (std::size_t i = 0; i < coupled.size(); ++i) {
    const auto [a, b] = coupled_pairs[i];
    blocks.push_back({begin(a), begin(b), width(a), width(b), coupled[i].data(), 4, true});
  }
  return lower_triangle(landmark_size(), blocks, landmark_damping);
}

Eigen::VectorXd NormalEquations::diagonal() const {
  Eigen::VectorXd out(size());
  for (std::size_t k = 0; k < keyframe.size(); ++k) out.segment<6>(6 * static_cast<Index>(k)) = keyframe[k].diagonal();
  for (int l = 0; l < landmarks(); ++l) {
    out.segment(keyframe_size() + begin(l), width(l)) = landmark[static_cast<std::size_t>(l)].diagonal().head(width(l));
  }
  return out;
}

Eigen::VectorXd NormalEquations::times(const Eigen::VectorXd& x) const {
  Eigen::VectorXd y(size());
  const Index offset = keyframe_size();
  for (std::size_t k = 0; k < keyframe.size(); ++k) {
    const Index row = 6 * static_cast<Index>(k);
    y.segment<6>(row).noalias() = keyframe[k] * x.segment<6>(row);
  }
  for (int l = 0; l < landmarks(); ++l) {
    const Index row = offset + begin(l);
    y.segment(row, width(l)).noalias() = landmark[static_cast<std::size_t>(l)].topLeftCorner(width(l), width(l)) * x.segment(row, width(l));
  }
  for (std::size_t i = 0; i < between.size(); ++i) {
    const Index a = 6 * between_pairs[i].first;
    const Index b = 6 * between_pairs[i].second;
    y.segment<6>(a).noalias() += between[i] * x.segment<6>(b);
    y.segment<6>(b).noalias() += between[i].transpose() * x.segment<6>(a);
  }
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Index p = offset + begin(seen_pairs[i].first);
    const Index k = 6 * seen_pairs[i].second;
    y.segment<6>(k).noalias() += seen[i] * x.segment<3>(p);
    y.segment<3>(p).noalias() += seen[i].transpose() * x.segment<6>(k);
  }
  for (std::size_t i = 0; i < coupled.size(); ++i) {
    const auto [a, b] = coupled_pairs[i];
    const auto block = coupled[i].topLeftCorner(width(a), width(b));
    y.segment(offset + begin(a), width(a)).noalias() += block * x.segment(offset + begin(b), width(b));
    y.segment(offset + begin(b), width(b)).noalias() += block.transpose() * x.segment(offset + begin(a), width(a));
  }
  return y;
}

}  // namespace sgraph
