#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <map>
#include <vector>

#include "sgraph_slam/core/graph/g2o.hpp"

namespace sgraph {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Triplets = std::vector<Eigen::Triplet<double>>;

// The keyframes that factors tie to the first, numbered from 0 without it (which has -1), and those factors.
struct Component {
  std::map<KeyframeId, int> number;
  std::vector<const Se3Between*> edges;
  int size = 0;
};

Component component_of_first(const Graph& graph) {
  Component out;
  std::vector<KeyframeId> open{graph.keyframes().begin()->first};
  out.number[open.front()] = -1;
  while (!open.empty()) {
    const KeyframeId at = open.back();
    open.pop_back();
    for (const FactorId id : graph.factors_of(at)) {
      const auto* edge = std::get_if<Se3Between>(&graph.find(id)->data);
      if (edge == nullptr) continue;
      const KeyframeId other = edge->from == at ? edge->to : edge->from;
      if (out.number.emplace(other, 0).second) open.push_back(other);
    }
  }
  for (auto& [id, number] : out.number) number = id == graph.keyframes().begin()->first ? -1 : out.size++;
  for (const auto& [id, factor] : graph.factors()) {
    const auto* edge = std::get_if<Se3Between>(&factor.data);
    if (edge != nullptr && out.number.count(edge->from) > 0) out.edges.push_back(edge);
  }
  return out;
}

// Normal equations of `sum weight |x_to - M x_from|^2` over blocks of `N` rows; the first keyframe's block is known.
template <int N>
class Relaxation {
 public:
  Relaxation(int blocks, const MatrixXd& first) : first_(first), right_(MatrixXd::Zero(N * blocks, first.cols())) {}

  void add(int from, int to, const Eigen::Matrix<double, N, N>& M, const MatrixXd& offset, double weight) {
    const Eigen::Matrix<double, N, N> one = Eigen::Matrix<double, N, N>::Identity();
    add_block(from, from, weight * M.transpose() * M);
    add_block(to, to, weight * one);
    add_block(to, from, -weight * M);
    add_block(from, to, -weight * M.transpose());
    if (to >= 0) right_.middleRows(N * to, N) += weight * offset;
    if (from >= 0) right_.middleRows(N * from, N) -= weight * M.transpose() * offset;
  }

  // Empty when the system is singular.
  MatrixXd solve() const {
    Eigen::SparseMatrix<double> H(right_.rows(), right_.rows());
    H.setFromTriplets(entries_.begin(), entries_.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(H);
    if (solver.info() != Eigen::Success) return {};
    MatrixXd x = solver.solve(right_);
    return x.allFinite() ? x : MatrixXd();
  }

 private:
  void add_block(int row, int column, const Eigen::Matrix<double, N, N>& block) {
    if (row < 0) return;
    if (column < 0) {
      right_.middleRows(N * row, N) -= block * first_;
      return;
    }
    for (int c = 0; c < N; ++c) {
      for (int r = 0; r < N; ++r) entries_.emplace_back(N * row + r, N * column + c, block(r, c));
    }
  }

  MatrixXd first_;
  MatrixXd right_;
  Triplets entries_;
};

Eigen::Quaterniond nearest_rotation(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) *= -1.0;
  return Eigen::Quaterniond(u * svd.matrixV().transpose()).normalized();
}

double mean_information(const Se3Between& edge, int begin) { return edge.weight.information().diagonal().segment<3>(begin).mean(); }

}  // namespace

void initialise_chordal(Graph& graph) {
  if (graph.keyframes().empty()) return;
  const Component component = component_of_first(graph);
  if (component.size == 0) return;
  const Pose first = graph.keyframes().begin()->second;

  // R_to = R_from Z: with the transposes as blocks, R_to^T = Z^T R_from^T.
  Relaxation<3> rotations(component.size, first.matrix().transpose());
  for (const Se3Between* edge : component.edges) {
    rotations.add(component.number.at(edge->from), component.number.at(edge->to), edge->T_from_to.matrix().transpose(), MatrixXd::Zero(3, 3),
                  mean_information(*edge, 0));
  }
  const MatrixXd R = rotations.solve();
  if (R.size() == 0) return;
  std::map<KeyframeId, Pose> poses{{graph.keyframes().begin()->first, first}};
  for (const auto& [id, number] : component.number) {
    if (number >= 0) poses[id].rotation = nearest_rotation(R.middleRows<3>(3 * number).transpose());
  }

  Relaxation<1> translations(component.size, first.translation.transpose());
  for (const Se3Between* edge : component.edges) {
    const Eigen::Vector3d step = poses.at(edge->from).rotation * edge->T_from_to.translation;
    translations.add(component.number.at(edge->from), component.number.at(edge->to), Eigen::Matrix<double, 1, 1>::Identity(), step.transpose(),
                     mean_information(*edge, 3));
  }
  const MatrixXd t = translations.solve();
  if (t.size() == 0) return;
  for (const auto& [id, number] : component.number) {
    if (number < 0) continue;
    poses[id].translation = t.row(number).transpose();
    graph.set(id, poses[id]);
  }
}

}  // namespace sgraph
