#pragma once

#include <utility>
#include <vector>

#include <Eigen/SparseCore>

#include "sgraph_slam/core/graph/variables.hpp"
#include "sgraph_slam/core/types/pose.hpp"

namespace sgraph {

/// `H = sum over the factors of w J^T J` and `g = sum of w J^T e` in our tangent spaces, with w what a factor's robust loss leaves it, in two parts:
///
///   H = [ B  E ; E^T  C ]   keyframes first, then the landmarks (planes, rooms, corridors), each part in the order of ids
///
/// B: diagonal blocks and those of odometry and loops; E: a block for each pair of keyframe and plane that sees it; C: diagonal blocks, and those
/// between planes, rooms and corridors, which are few and local.
class NormalEquations {
 public:
  using Pair = std::pair<int, int>;
  using Block63 = Eigen::Matrix<double, 6, 3>;

  /// The pattern; pairs may repeat and come in any order. `landmark_ids` in the order of the landmarks. `between`: keyframes (a < b). `seen`:
  /// (landmark, keyframe). `coupled`: landmarks (a < b).
  NormalEquations(int keyframes, std::vector<int> landmark_widths, std::vector<Pair> between, std::vector<Pair> seen, std::vector<Pair> coupled);

  void set_zero();

  [[nodiscard]] int keyframes() const { return static_cast<int>(keyframe.size()); }
  [[nodiscard]] int landmarks() const { return static_cast<int>(landmark.size()); }
  [[nodiscard]] Eigen::Index keyframe_size() const { return 6 * static_cast<Eigen::Index>(keyframe.size()); }
  [[nodiscard]] Eigen::Index landmark_size() const { return begin_.back(); }
  [[nodiscard]] Eigen::Index size() const { return keyframe_size() + landmark_size(); }
  /// First row of a landmark within its part, and its degrees of freedom.
  [[nodiscard]] Eigen::Index begin(int of_landmark) const { return begin_[static_cast<std::size_t>(of_landmark)]; }
  [[nodiscard]] Eigen::Index width(int of_landmark) const { return begin(of_landmark + 1) - begin(of_landmark); }

  /// Of all variables, keyframes first: first row and degrees of freedom in the whole, and whether a factor joins the two or they are one.
  [[nodiscard]] Eigen::Index row(int variable) const;
  [[nodiscard]] Eigen::Index degrees(int variable) const { return variable < keyframes() ? 6 : width(variable - keyframes()); }
  [[nodiscard]] bool joined(int a, int b) const;

  /// Places of the pairs' blocks.
  [[nodiscard]] std::size_t between_at(Pair pair) const { return at(between_pairs, pair); }
  [[nodiscard]] std::size_t seen_at(Pair pair) const { return at(seen_pairs, pair); }
  [[nodiscard]] std::size_t coupled_at(Pair pair) const { return at(coupled_pairs, pair); }

  /// Lower triangle of H with `damping` added to the diagonal, and of C alone.
  [[nodiscard]] Eigen::SparseMatrix<double> matrix(const Eigen::VectorXd& damping) const;
  [[nodiscard]] Eigen::SparseMatrix<double> landmark_matrix(const Eigen::VectorXd& landmark_damping) const;
  [[nodiscard]] Eigen::VectorXd diagonal() const;
  /// `H x`.
  [[nodiscard]] Eigen::VectorXd times(const Eigen::VectorXd& x) const;

  // Sorted, each once.
  std::vector<Pair> between_pairs;
  std::vector<Pair> seen_pairs;
  std::vector<Pair> coupled_pairs;

  std::vector<Eigen::Matrix<double, 6, 6>> keyframe;  ///< diagonal blocks
  std::vector<Eigen::Matrix<double, 6, 6>> between;   ///< rows of the first of the pair, columns of the second
  std::vector<Block63> seen;                          ///< rows of the keyframe, columns of the plane
  std::vector<Eigen::Matrix4d> landmark;              ///< diagonal blocks, in the top left corner
  std::vector<Eigen::Matrix4d> coupled;               ///< rows of the first, columns of the second, in the top left corner
  Eigen::VectorXd gradient;
  std::vector<Pose> poses;  ///< T_map_base of the keyframes, where this was linearised

 private:
  static std::size_t at(const std::vector<Pair>& pairs, Pair pair);

  std::vector<Eigen::Index> begin_;
};

}  // namespace sgraph
