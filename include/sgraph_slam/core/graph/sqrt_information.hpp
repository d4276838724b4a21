#pragma once

#include <Eigen/Core>

namespace sgraph {

/// Weight of a residual: the upper triangular `W` with `W^T W = covariance^-1`, so that `|W e|^2` is the squared Mahalanobis length of `e`. It can
/// only be made from something whose name tells what it is, so that a standard deviation is never taken for a variance. Non-finite input gives a
/// non-finite weight, which the graph refuses.
template <int N>
class SqrtInformation {
 public:
  using Matrix = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;

  /// Weight one: residual already in units of its standard deviation.
  SqrtInformation() : matrix_(Matrix::Identity()) {}

  /// Independent components with these standard deviations, all positive.
  static SqrtInformation from_std_dev(const Vector& std_dev);

  /// A covariance, made no smaller than `diag(floor_std_dev^2)` in any direction (its eigenvalues are bounded after scaling with the floors, so that
  /// components of different units don't mix). The floors are positive; a covariance that is singular or slightly indefinite is fine.
  static SqrtInformation from_covariance(const Matrix& covariance, const Vector& floor_std_dev);

  /// An information matrix as pose-graph files hold it; directions without information get none.
  static SqrtInformation from_information(const Matrix& information);

  /// A weight that has been taken from `matrix()` before (reading a file).
  static SqrtInformation from_factor(const Matrix& upper_triangular) { return SqrtInformation(upper_triangular); }

  [[nodiscard]] const Matrix& matrix() const { return matrix_; }
  [[nodiscard]] Matrix information() const { return matrix_.transpose() * matrix_; }

  friend bool operator==(const SqrtInformation& a, const SqrtInformation& b) { return a.matrix_ == b.matrix_; }

 private:
  explicit SqrtInformation(const Matrix& matrix) : matrix_(matrix) {}

  Matrix matrix_;
};

extern template class SqrtInformation<1>;
extern template class SqrtInformation<3>;
extern template class SqrtInformation<6>;

}  // namespace sgraph
