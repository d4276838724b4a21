#include "coarse_motion.hpp"

#include <algorithm>

#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph {

using Eigen::Index;

CoarseMotion::CoarseMotion(const std::vector<int>& nodes, const std::vector<Pose>& T_map_base)
    : nodes_(static_cast<int>(nodes.size())), influences_(T_map_base.size()) {
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const int begin = nodes[n];
    const int end = n + 1 < nodes.size() ? nodes[n + 1] : begin + 1;
    for (int k = begin; k < end; ++k) {
      Influence& influence = influences_[static_cast<std::size_t>(k)];
      influence.node = {static_cast<int>(n), static_cast<int>(n) + 1};
      if (k == begin) {
        influence.by[0].setIdentity();
        continue;
      }
      const double share = static_cast<double>(k - begin) / (end - begin);
      const Pose T_k_map = T_map_base[static_cast<std::size_t>(k)].inverse();
      influence.count = 2;
      influence.by[0] = (1 - share) * se3_adjoint(T_k_map * T_map_base[static_cast<std::size_t>(begin)]);
      influence.by[1] = share * se3_adjoint(T_k_map * T_map_base[static_cast<std::size_t>(end)]);
    }
  }
}

Eigen::VectorXd CoarseMotion::restricted(const Eigen::VectorXd& r) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(size());
  for (std::size_t k = 0; k < influences_.size(); ++k) {
    const Influence& influence = influences_[k];
    for (std::size_t i = 0; i < static_cast<std::size_t>(influence.count); ++i) {
      out.segment<6>(6 * influence.node[i]).noalias() += influence.by[i].transpose() * r.segment<6>(6 * static_cast<Index>(k));
    }
  }
  return out;
}

Eigen::VectorXd CoarseMotion::prolonged(const Eigen::VectorXd& y) const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(6 * static_cast<Index>(influences_.size()));
  for (std::size_t k = 0; k < influences_.size(); ++k) {
    const Influence& influence = influences_[k];
    for (std::size_t i = 0; i < static_cast<std::size_t>(influence.count); ++i) {
      out.segment<6>(6 * static_cast<Index>(k)).noalias() += influence.by[i] * y.segment<6>(6 * influence.node[i]);
    }
  }
  return out;
}

Eigen::MatrixXd CoarseMotion::keyframe_part(const NormalEquations& equations, const Eigen::VectorXd& damping) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(size(), size());
  const auto add = [&](const Matrix6& block, const Influence& a, const Influence& b, bool mirrored) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(a.count); ++i) {
      const Matrix6 half = a.by[i].transpose() * block;
      for (std::size_t j = 0; j < static_cast<std::size_t>(b.count); ++j) {
        const Matrix6 whole = half * b.by[j];
        out.block<6, 6>(6 * a.node[i], 6 * b.node[j]) += whole;
        if (mirrored) out.block<6, 6>(6 * b.node[j], 6 * a.node[i]) += whole.transpose();
      }
    }
  };
  for (int k = 0; k < equations.keyframes(); ++k) {
    Matrix6 block = equations.keyframe[static_cast<std::size_t>(k)];
    block.diagonal() += damping.segment<6>(6 * k);
    add(block, of(k), of(k), false);
  }
  for (std::size_t i = 0; i < equations.between.size(); ++i) {
    add(equations.between[i], of(equations.between_pairs[i].first), of(equations.between_pairs[i].second), true);
  }
  return out;
}

void CoarseMotion::restrict_seen(const NormalEquations& equations, std::size_t first, std::size_t last,
                                 const std::vector<NormalEquations::Block63>& blocks,
                                 std::vector<std::pair<int, NormalEquations::Block63>>& out) const {
  out.clear();
  for (std::size_t s = first; s < last; ++s) {
    const Influence& influence = of(equations.seen_pairs[s].second);
    for (std::size_t i = 0; i < static_cast<std::size_t>(influence.count); ++i) {
      const int node = influence.node[i];
      const NormalEquations::Block63 part = influence.by[i].transpose() * blocks[s];
      // Keyframes ascend, so a node is the newest or the one before.
      if (!out.empty() && out.back().first == node) {
        out.back().second += part;
      } else if (out.size() > 1 && out[out.size() - 2].first == node) {
        out[out.size() - 2].second += part;
      } else {
        out.emplace_back(node, part);
      }
    }
  }
}

std::vector<int> every(int step, int count, int fine) {
  std::vector<int> out;
  const int single = std::max(0, count - std::max(fine, 1));
  for (int k = 0; k < single; k += step) out.push_back(k);
  for (int k = single; k < count; ++k) out.push_back(k);
  return out;
}

}  // namespace sgraph
