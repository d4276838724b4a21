#pragma once

#include <array>
#include <vector>

#include "normal_equations.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// A trajectory that bends at some of its keyframes only, the nodes: between two nodes a keyframe moves with both, the nearer the more, each carrying
/// it along as a rigid body. Six coordinates a node: the tangent space of its keyframe.
class CoarseMotion {
 public:
  /// How a keyframe moves with its nodes: `xi = by[0] eta[node[0]] + by[1] eta[node[1]]`; one node where it is itself one.
  struct Influence {
    std::array<int, 2> node{0, 0};
    std::array<Matrix6, 2> by;
    int count = 1;
  };

  /// `nodes`: numbers of keyframes, ascending, the first and the last among them; `T_map_base` of all.
  CoarseMotion(const std::vector<int>& nodes, const std::vector<Pose>& T_map_base);

  [[nodiscard]] int nodes() const { return nodes_; }
  [[nodiscard]] Eigen::Index size() const { return 6 * static_cast<Eigen::Index>(nodes_); }
  [[nodiscard]] const Influence& of(int keyframe) const { return influences_[static_cast<std::size_t>(keyframe)]; }

  /// Force on the nodes `P^T r` of a force on the keyframes, and motion of the keyframes `P y` of one of the nodes.
  [[nodiscard]] Eigen::VectorXd restricted(const Eigen::VectorXd& r) const;
  [[nodiscard]] Eigen::VectorXd prolonged(const Eigen::VectorXd& y) const;

  /// `P^T B P` with the damping added to the diagonal of B; lower triangle at least.
  [[nodiscard]] Eigen::MatrixXd keyframe_part(const NormalEquations& equations, const Eigen::VectorXd& damping) const;

  /// The landmark's blocks of `P^T W`, W given by `blocks` at the equations' places `first` to `last` of `seen`; node and block, ascending.
  void restrict_seen(const NormalEquations& equations, std::size_t first, std::size_t last, const std::vector<NormalEquations::Block63>& blocks,
                     std::vector<std::pair<int, NormalEquations::Block63>>& out) const;

 private:
  int nodes_;
  std::vector<Influence> influences_;
};

/// Every `step`-th of `count` keyframes, the last `fine` ones each, and the last of all.
std::vector<int> every(int step, int count, int fine = 0);

}  // namespace sgraph
