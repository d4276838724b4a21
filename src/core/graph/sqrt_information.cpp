#include "sgraph_slam/core/graph/sqrt_information.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Dense>

namespace sgraph {
namespace {

// Upper triangular W with W^T W = root^T root, positive diagonal.
template <int N>
Eigen::Matrix<double, N, N> triangular(const Eigen::Matrix<double, N, N>& root) {
  using Matrix = Eigen::Matrix<double, N, N>;
  Matrix w = Eigen::HouseholderQR<Matrix>(root).matrixQR();
  w = w.template triangularView<Eigen::Upper>().toDenseMatrix().eval();
  for (int i = 0; i < N; ++i) {
    if (w(i, i) < 0) w.row(i) *= -1.0;
  }
  return w;
}

template <int N>
Eigen::Matrix<double, N, N> not_a_number() {
  return Eigen::Matrix<double, N, N>::Constant(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace

template <int N>
SqrtInformation<N> SqrtInformation<N>::from_std_dev(const Vector& std_dev) {
  return SqrtInformation(std_dev.cwiseInverse().asDiagonal());
}

template <int N>
SqrtInformation<N> SqrtInformation<N>::from_covariance(const Matrix& covariance, const Vector& floor_std_dev) {
  if (!covariance.allFinite() || !floor_std_dev.allFinite()) return SqrtInformation(not_a_number<N>());
  const Vector scale = floor_std_dev.cwiseInverse();
  const Matrix scaled = scale.asDiagonal() * (0.5 * (covariance + covariance.transpose())) * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(scaled);
  const Vector inverse_root = eigen.eigenvalues().cwiseMax(1.0).cwiseSqrt().cwiseInverse();
  return SqrtInformation(triangular<N>(inverse_root.asDiagonal() * eigen.eigenvectors().transpose() * scale.asDiagonal()));
}

template <int N>
SqrtInformation<N> SqrtInformation<N>::from_information(const Matrix& information) {
  if (!information.allFinite()) return SqrtInformation(not_a_number<N>());
  const Eigen::SelfAdjointEigenSolver<Matrix> eigen(0.5 * (information + information.transpose()));
  const Vector root = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return SqrtInformation(triangular<N>(root.asDiagonal() * eigen.eigenvectors().transpose()));
}

template class SqrtInformation<1>;
template class SqrtInformation<3>;
template class SqrtInformation<6>;

}  // namespace sgraph
