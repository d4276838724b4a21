#include <algorithm>
#include <map>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

#include "coarse_motion.hpp"
#include "covariances.hpp"

namespace sgraph {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Block63 = NormalEquations::Block63;

constexpr int newest = 8;                 // keyframes that are nodes each: what they see is associated by what is known of them
constexpr double smallest_pivot = 1e-14;  // as of the exact ones

class CoarseCovariances final : public Covariances {
 public:
  CoarseCovariances(const NormalEquations& equations, int most_nodes)
      : equations_(equations), motion_(nodes_of(equations.keyframes(), most_nodes), equations.poses) {
    if (!factorize_landmarks()) return;
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(equations.size());
    MatrixXd reduced = motion_.keyframe_part(equations, none);
    subtract_single_landmarks(reduced);
    subtract_coupled_landmarks(reduced);
    factor_.compute(reduced);
    if (factor_.info() != Eigen::Success) return;
    const Eigen::VectorXd pivots = factor_.matrixLLT().diagonal().cwiseAbs2();
    ok_ = pivots.size() == 0 || (pivots.allFinite() && pivots.minCoeff() > smallest_pivot * pivots.maxCoeff());
  }

  [[nodiscard]] bool ok() const override { return ok_; }

  MatrixXd block(int a, int b) override {
    MatrixXd whole = half(a).transpose() * half(b);
    const int keyframes = equations_.keyframes();
    if (a < keyframes && b < keyframes) return whole;
    if (a < keyframes || b < keyframes) return -whole;
    return whole + of_landmarks_alone(a - keyframes, b - keyframes);
  }

 private:
  static std::vector<int> nodes_of(int keyframes, int most_nodes) {
    const int old = std::max(0, keyframes - newest);
    return every(std::max(1, (old + most_nodes - 1) / std::max(1, most_nodes)), keyframes, newest);
  }

  [[nodiscard]] bool single(int landmark) const { return place_[static_cast<std::size_t>(landmark)] < 0; }

  // C: blocks of their own, and those that factors join, together.
  bool factorize_landmarks() {
    place_.assign(static_cast<std::size_t>(equations_.landmarks()), -1);
    for (const auto& [a, b] : equations_.coupled_pairs) place_[static_cast<std::size_t>(a)] = place_[static_cast<std::size_t>(b)] = 0;
    inverse_.resize(place_.size());
    std::vector<Eigen::Triplet<double>> entries;
    for (int l = 0; l < equations_.landmarks(); ++l) {
      const auto i = static_cast<std::size_t>(l);
      const Index width = equations_.width(l);
      const MatrixXd own = equations_.landmark[i].topLeftCorner(width, width);
      if (single(l)) {
        const Eigen::LLT<MatrixXd> factor(own);
        if (factor.info() != Eigen::Success) return false;
        inverse_[i] = factor.solve(MatrixXd::Identity(width, width));
        continue;
      }
      place_[i] = static_cast<int>(coupled_size_);
      add_lower(entries, coupled_size_, coupled_size_, own);
      coupled_size_ += width;
    }
    for (std::size_t i = 0; i < equations_.coupled.size(); ++i) {
      const auto [a, b] = equations_.coupled_pairs[i];
      const MatrixXd part = equations_.coupled[i].topLeftCorner(equations_.width(a), equations_.width(b)).transpose();
      add_lower(entries, place_[static_cast<std::size_t>(b)], place_[static_cast<std::size_t>(a)], part);
    }
    if (coupled_size_ == 0) return true;
    Eigen::SparseMatrix<double> C(coupled_size_, coupled_size_);
    C.setFromTriplets(entries.begin(), entries.end());
    coupled_.compute(C);
    return coupled_.info() == Eigen::Success;
  }

  static void add_lower(std::vector<Eigen::Triplet<double>>& entries, Index row, Index column, const MatrixXd& block) {
    for (Index c = 0; c < block.cols(); ++c) {
      for (Index r = 0; r < block.rows(); ++r) {
        if (row + r >= column + c) entries.emplace_back(static_cast<int>(row + r), static_cast<int>(column + c), block(r, c));
      }
    }
  }

  void subtract_single_landmarks(MatrixXd& reduced) {
    seen_.resize(place_.size());
    const auto& pairs = equations_.seen_pairs;
    for (std::size_t first = 0, last = 0; first < pairs.size(); first = last) {
      const int landmark = pairs[first].first;
      while (last < pairs.size() && pairs[last].first == landmark) ++last;
      auto& seen = seen_[static_cast<std::size_t>(landmark)];
      motion_.restrict_seen(equations_, first, last, equations_.seen, seen);
      if (!single(landmark)) continue;
      const Eigen::Matrix3d inverse = inverse_[static_cast<std::size_t>(landmark)];
      for (std::size_t i = 0; i < seen.size(); ++i) {
        const Block63 weighted = seen[i].second * inverse;
        for (std::size_t j = 0; j <= i; ++j) {
          reduced.block<6, 6>(6 * seen[i].first, 6 * seen[j].first).noalias() -= weighted.lazyProduct(seen[j].second.transpose());
        }
      }
    }
  }

  void subtract_coupled_landmarks(MatrixXd& reduced) {
    if (coupled_size_ == 0) return;
    MatrixXd by_nodes = MatrixXd::Zero(coupled_size_, motion_.size());
    for (std::size_t l = 0; l < seen_.size(); ++l) {
      if (place_[l] < 0) continue;
      for (const auto& [node, part] : seen_[l]) by_nodes.block<3, 6>(place_[l], 6 * node) += part.transpose();
    }
    by_nodes = coupled_.permutationP() * by_nodes;
    coupled_.matrixL().solveInPlace(by_nodes);
    reduced.selfadjointView<Eigen::Lower>().rankUpdate(by_nodes.transpose(), -1.0);
  }

  // Columns of the landmark in the inverse of the coupled part of C.
  const MatrixXd& coupled_columns(int landmark) {
    const auto found = coupled_columns_.find(landmark);
    if (found != coupled_columns_.end()) return found->second;
    MatrixXd unit = MatrixXd::Zero(coupled_size_, equations_.width(landmark));
    unit.middleRows(place_[static_cast<std::size_t>(landmark)], unit.cols()).setIdentity();
    return coupled_columns_.emplace(landmark, coupled_.solve(unit)).first->second;
  }

  MatrixXd of_landmarks_alone(int a, int b) {
    if (single(a) || single(b)) return a == b ? inverse_[static_cast<std::size_t>(a)] : MatrixXd::Zero(equations_.width(a), equations_.width(b));
    return coupled_columns(b).middleRows(place_[static_cast<std::size_t>(a)], equations_.width(a));
  }

  // With the factor L of the reduced matrix: `L^-1 P^T` of a keyframe, `L^-1 E C^-1` of a landmark. Products of two halves are covariances.
  const MatrixXd& half(int variable) {
    const auto found = halves_.find(variable);
    if (found != halves_.end()) return found->second;
    MatrixXd out = MatrixXd::Zero(motion_.size(), equations_.degrees(variable));
    if (variable < equations_.keyframes()) {
      const CoarseMotion::Influence& influence = motion_.of(variable);
      for (std::size_t i = 0; i < static_cast<std::size_t>(influence.count); ++i)
        out.middleRows<6>(6 * influence.node[i]) = influence.by[i].transpose();
    } else if (const int landmark = variable - equations_.keyframes(); single(landmark)) {
      for (const auto& [node, part] : seen_[static_cast<std::size_t>(landmark)]) {
        out.middleRows<6>(6 * node) += part * inverse_[static_cast<std::size_t>(landmark)];
      }
    } else {
      const MatrixXd& columns = coupled_columns(landmark);
      for (std::size_t l = 0; l < seen_.size(); ++l) {
        if (place_[l] < 0) continue;
        for (const auto& [node, part] : seen_[l]) out.middleRows<6>(6 * node).noalias() += part * columns.middleRows<3>(place_[l]);
      }
    }
    // What was first seen late has nothing before: nodes are in the order of time.
    const auto of_node = [&out](Index node) { return out.middleRows<6>(6 * node); };
    Index node = 0;
    while (6 * node < out.rows() && of_node(node).isZero(0)) ++node;
    const Index rest = out.rows() - 6 * node;
    factor_.matrixLLT().bottomRightCorner(rest, rest).triangularView<Eigen::Lower>().solveInPlace(out.bottomRows(rest));
    return halves_.emplace(variable, std::move(out)).first->second;
  }

  const NormalEquations& equations_;
  CoarseMotion motion_;
  std::vector<int> place_;         // of each landmark in the coupled part; -1: joined with no other
  std::vector<MatrixXd> inverse_;  // of the single ones
  Index coupled_size_ = 0;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> coupled_;
  std::vector<std::vector<std::pair<int, Block63>>> seen_;  // E, by node, of each landmark
  Eigen::LLT<MatrixXd> factor_;
  std::map<int, MatrixXd> coupled_columns_;
  std::map<int, MatrixXd> halves_;
  bool ok_ = false;
};

}  // namespace

std::unique_ptr<Covariances> make_coarse_covariances(const NormalEquations& equations, int most_nodes) {
  return std::make_unique<CoarseCovariances>(equations, most_nodes);
}

}  // namespace sgraph
