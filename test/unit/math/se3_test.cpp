#include "sgraph_slam/core/math/se3.hpp"

#include <gtest/gtest.h>

#include <random>

#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/types/plane.hpp"

namespace sgraph {
namespace {

// Seeded tangent vectors, among them awkward ones: zero, tiny, close to a half turn.
std::vector<Vector6> tangents() {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<Vector6> all{Vector6::Zero()};
  for (int i = 0; i < 200; ++i) {
    Vector6 xi;
    for (int k = 0; k < 6; ++k) xi[k] = normal(random);
    const double angle = i % 4 == 0 ? 1e-7 : i % 4 == 1 ? M_PI - 1e-4 : i % 4 == 2 ? 0.1 * (1 + 1e-9 * i) : 0.05 * (i % 50);
    xi.head<3>() *= angle / xi.head<3>().norm();
    all.push_back(xi);
  }
  return all;
}

TEST(Se3, LogUndoesExp) {
  for (const Vector6& xi : tangents()) EXPECT_LT((se3_log(se3_exp(xi)) - xi).norm(), 1e-8 * (1 + xi.norm()));
}

TEST(Se3, AdjointMovesTangentsThroughAPose) {
  const auto all = tangents();
  for (std::size_t i = 1; i + 1 < all.size(); ++i) {
    const Pose T = se3_exp(all[i]);
    const Vector6 xi = 0.1 * all[i + 1];
    const Pose left = T * se3_exp(xi);
    const Pose right = se3_exp(se3_adjoint(T) * xi) * T;
    EXPECT_LT(se3_log(left.inverse() * right).norm(), 1e-10);
  }
}

TEST(Se3, RightJacobianInverseAgreesWithDifferences) {
  for (const Vector6& xi : tangents()) {
    if (xi.head<3>().norm() > M_PI - 1e-3) continue;  // the logarithm jumps there
    const Matrix6 analytic = se3_right_jacobian_inverse(xi);
    for (int k = 0; k < 6; ++k) {
      const double h = 1e-6;
      const Vector6 step = h * Vector6::Unit(k);
      const Vector6 numeric = (se3_log(se3_exp(xi) * se3_exp(step)) - se3_log(se3_exp(xi) * se3_exp(-step))) / (2 * h);
      EXPECT_LT((numeric - analytic.col(k)).norm(), 1e-6 * (1 + analytic.col(k).norm())) << xi.transpose();
    }
  }
}

TEST(Se3, InterpolationPassesThroughItsEnds) {
  const auto all = tangents();
  for (std::size_t i = 1; i + 1 < all.size(); ++i) {
    const Pose a = se3_exp(all[i]);
    const Pose b = se3_exp(all[i + 1]);
    EXPECT_LT(se3_log(interpolate(a, b, 0).inverse() * a).norm(), 1e-9);
    EXPECT_LT(se3_log(interpolate(a, b, 1).inverse() * b).norm(), 1e-6);
  }
}

TEST(So3, TangentBasisIsARightHandedFrame) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    Eigen::Vector3d n(normal(random), normal(random), normal(random));
    if (i == 0) n = -Eigen::Vector3d::UnitZ();
    if (i == 1) n = Eigen::Vector3d::UnitX();
    n.normalize();
    const auto basis = tangent_basis(n);
    EXPECT_LT((basis.transpose() * basis - Eigen::Matrix2d::Identity()).norm(), 1e-12);
    EXPECT_LT((basis.col(0).cross(basis.col(1)) - n).norm(), 1e-12);
  }
}

TEST(Plane, DistancesDontDependOnTheFrame) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (const Vector6& xi : tangents()) {
    const Pose T = se3_exp(xi);
    const Eigen::Vector3d n = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    const Plane plane{n, normal(random)};
    const Eigen::Vector3d p(normal(random), normal(random), normal(random));
    EXPECT_NEAR((T * plane).distance(T * p), plane.distance(p), 1e-10);
  }
}

}  // namespace
}  // namespace sgraph
