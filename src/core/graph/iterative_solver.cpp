#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>

#include "coarse_motion.hpp"
#include "linear_solver.hpp"

namespace sgraph {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Block63 = NormalEquations::Block63;

constexpr int group_length = 8;       // keyframes solved exactly together; longer ones cost more to factor than they save
constexpr int most_nodes = 120;       // of the coarse problem, whose cost grows with the cube
constexpr int most_iterations = 400;  // a step that isn't exact is still a step downhill
constexpr int look_back = 4;          // iterations: how much they gained tells what was left to gain before them (Hestenes and Stiefel 1952)

// An approximation of the inverse of the reduced matrix `S = B - E C^-1 E^T`, in which factors between landmarks hold each to where the other is now.
class Preconditioner {
 public:
  bool factorize(const NormalEquations& equations, const VectorXd& damping) {
    const int count = equations.keyframes();
    groups_.clear();
    for (int k = 0; k < count; k += group_length) {
      const int length = std::min(group_length, count - k);
      groups_.push_back({k, MatrixXd::Zero(6 * length, 6 * length), {}});
    }
    const int step = std::max(group_length, (count + most_nodes - 1) / most_nodes);
    coarse_.emplace(every(step, count), equations.poses);
    MatrixXd coarse = coarse_->keyframe_part(equations, damping);
    add_keyframes(equations, damping);
    if (!subtract_landmarks(equations, damping, coarse)) return false;
    for (Group& group : groups_) {
      group.factor.compute(group.matrix);
      if (group.factor.info() != Eigen::Success) return false;
    }
    coarse_factor_.compute(coarse);
    return coarse_factor_.info() == Eigen::Success;
  }

  [[nodiscard]] VectorXd operator()(const VectorXd& r) const {
    VectorXd z = coarse_->prolonged(coarse_factor_.solve(coarse_->restricted(r)));
    for (const Group& group : groups_)
      z.segment(6 * group.begin, group.matrix.rows()) += group.factor.solve(r.segment(6 * group.begin, group.matrix.rows()));
    return z;
  }

 private:
  struct Group {
    int begin;
    MatrixXd matrix;
    Eigen::LLT<MatrixXd> factor;
  };

  static Index row_in_group(int keyframe) { return 6 * (keyframe % group_length); }
  Group& group_of(int keyframe) { return groups_[static_cast<std::size_t>(keyframe / group_length)]; }

  void add_keyframes(const NormalEquations& equations, const VectorXd& damping) {
    for (int k = 0; k < equations.keyframes(); ++k) {
      auto block = group_of(k).matrix.block<6, 6>(row_in_group(k), row_in_group(k));
      block = equations.keyframe[static_cast<std::size_t>(k)];
      block.diagonal() += damping.segment<6>(6 * k);
    }
    for (std::size_t i = 0; i < equations.between.size(); ++i) {
      const auto [a, b] = equations.between_pairs[i];
      if (a / group_length != b / group_length) continue;
      group_of(a).matrix.block<6, 6>(row_in_group(b), row_in_group(a)) += equations.between[i].transpose();  // the lower triangle will do
    }
  }

  bool subtract_landmarks(const NormalEquations& equations, const VectorXd& damping, MatrixXd& coarse) {
    const auto& pairs = equations.seen_pairs;
    std::vector<Block63> whitened(pairs.size());  // W with W W^T = E D^-1 E^T, D the landmark's own block
    std::vector<std::pair<int, Block63>> at_nodes;
    for (std::size_t first = 0, last = 0; first < pairs.size(); first = last) {
      const int landmark = pairs[first].first;
      while (last < pairs.size() && pairs[last].first == landmark) ++last;
      Eigen::Matrix3d own = equations.landmark[static_cast<std::size_t>(landmark)].topLeftCorner<3, 3>();
      own.diagonal() += damping.segment<3>(equations.keyframe_size() + equations.begin(landmark));
      const Eigen::LLT<Eigen::Matrix3d> factor(own);
      if (factor.info() != Eigen::Success) return false;
      const Eigen::Matrix3d whiten = factor.matrixU().solve(Eigen::Matrix3d::Identity());
      for (std::size_t s = first; s < last; ++s) whitened[s].noalias() = equations.seen[s] * whiten;
      for (std::size_t s = first; s < last; ++s) {
        const int k = pairs[s].second;
        MatrixXd& matrix = group_of(k).matrix;
        for (std::size_t t = first; t <= s; ++t) {
          if (pairs[t].second / group_length != k / group_length) continue;
          matrix.block<6, 6>(row_in_group(k), row_in_group(pairs[t].second)).noalias() -= whitened[s].lazyProduct(whitened[t].transpose());
        }
      }
      coarse_->restrict_seen(equations, first, last, whitened, at_nodes);
      for (std::size_t i = 0; i < at_nodes.size(); ++i) {
        for (std::size_t j = 0; j <= i; ++j) {
          coarse.block<6, 6>(6 * at_nodes[i].first, 6 * at_nodes[j].first).noalias() -=
              at_nodes[i].second.lazyProduct(at_nodes[j].second.transpose());
        }
      }
    }
    return true;
  }

  std::vector<Group> groups_;
  std::optional<CoarseMotion> coarse_;
  Eigen::LLT<MatrixXd> coarse_factor_;
};

class IterativeSolver final : public LinearSolver {
 public:
  bool factorize(const NormalEquations& equations, const VectorXd& damping) override {
    equations_ = &equations;
    damping_ = damping;
    const Eigen::SparseMatrix<double> C = equations.landmark_matrix(damping.tail(equations.landmark_size()));
    if (!analyzed_) landmarks_.analyzePattern(C);
    analyzed_ = true;
    landmarks_.factorize(C);
    return landmarks_.info() == Eigen::Success && preconditioner_.factorize(equations, damping);
  }

  VectorXd solve(const VectorXd& b, double tolerance) override {
    const Index keyframe_size = equations_->keyframe_size();
    VectorXd out(b.size());
    const VectorXd of_landmarks = landmarks_.solve(b.tail(equations_->landmark_size()));
    out.head(keyframe_size) = conjugate_gradients(b.head(keyframe_size) - seen_times(of_landmarks), tolerance);
    out.tail(equations_->landmark_size()) = landmarks_.solve(b.tail(equations_->landmark_size()) - seen_transposed_times(out.head(keyframe_size)));
    return out;
  }

  [[nodiscard]] int iterations() const override { return iterations_; }

 private:
  [[nodiscard]] VectorXd seen_times(const VectorXd& x) const {
    VectorXd y = VectorXd::Zero(equations_->keyframe_size());
    for (std::size_t s = 0; s < equations_->seen.size(); ++s) {
      const auto [landmark, k] = equations_->seen_pairs[s];
      y.segment<6>(6 * k).noalias() += equations_->seen[s] * x.segment<3>(equations_->begin(landmark));
    }
    return y;
  }

  [[nodiscard]] VectorXd seen_transposed_times(const VectorXd& x) const {
    VectorXd y = VectorXd::Zero(equations_->landmark_size());
    for (std::size_t s = 0; s < equations_->seen.size(); ++s) {
      const auto [landmark, k] = equations_->seen_pairs[s];
      y.segment<3>(equations_->begin(landmark)).noalias() += equations_->seen[s].transpose() * x.segment<6>(6 * k);
    }
    return y;
  }

  [[nodiscard]] VectorXd reduced_times(const VectorXd& x) const {
    VectorXd y = damping_.head(x.size()).cwiseProduct(x) - seen_times(landmarks_.solve(seen_transposed_times(x)));
    for (int k = 0; k < equations_->keyframes(); ++k)
      y.segment<6>(6 * k).noalias() += equations_->keyframe[static_cast<std::size_t>(k)] * x.segment<6>(6 * k);
    for (std::size_t i = 0; i < equations_->between.size(); ++i) {
      const auto [a, b] = equations_->between_pairs[i];
      y.segment<6>(6 * a).noalias() += equations_->between[i] * x.segment<6>(6 * b);
      y.segment<6>(6 * b).noalias() += equations_->between[i].transpose() * x.segment<6>(6 * a);
    }
    return y;
  }

  VectorXd conjugate_gradients(VectorXd r, double tolerance) {
    VectorXd x = VectorXd::Zero(r.size());
    VectorXd z = preconditioner_(r);
    VectorXd p = z;
    double rz = r.dot(z);
    double gained = 0;
    std::deque<double> lately;
    for (iterations_ = 0; iterations_ < most_iterations && rz > 0; ++iterations_) {
      const VectorXd q = reduced_times(p);
      const double curvature = p.dot(q);
      if (!(curvature > 0)) break;  // rounding: nothing is left to gain
      const double length = rz / curvature;
      x += length * p;
      r -= length * q;
      gained += length * rz;
      lately.push_back(length * rz);
      if (lately.size() > look_back) lately.pop_front();
      if (lately.size() == look_back && std::accumulate(lately.begin(), lately.end(), 0.0) <= tolerance * tolerance * gained) break;
      z = preconditioner_(r);
      const double next = r.dot(z);
      p = z + (next / rz) * p;
      rz = next;
    }
    return x;
  }

  const NormalEquations* equations_ = nullptr;
  VectorXd damping_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> landmarks_;
  Preconditioner preconditioner_;
  bool analyzed_ = false;
  int iterations_ = 0;
};

// Operations an iteration takes a block of `seen`, and how many iterations a solve takes, measured.
constexpr double operations_a_block = 72;
constexpr double usual_iterations = 30;

}  // namespace

std::unique_ptr<LinearSolver> make_iterative_solver() { return std::make_unique<IterativeSolver>(); }

std::unique_ptr<LinearSolver> make_linear_solver(const NormalEquations& pattern) {
  // Without landmarks the keyframes' own graph is sparse, and loops that close long chains are what conjugate gradients take long for.
  if (pattern.seen.size() < pattern.between.size()) return make_direct_solver();
  const double iterative = usual_iterations * operations_a_block * static_cast<double>(pattern.seen.size());
  return factorization_cost(pattern) <= iterative ? make_direct_solver() : make_iterative_solver();
}

}  // namespace sgraph
