#include "sgraph_slam/core/segmentation/plane_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/util/rng.hpp"

namespace sgraph {
namespace {

Eigen::Vector3d gaussian(RandomStream& random) { return {random.next_normal(), random.next_normal(), random.next_normal()}; }

// Points spread over a 4 x 2 m patch of the plane around `centre`, with noise along the normal.
Eigen::Matrix4d patch(const Plane& plane, const Eigen::Vector3d& centre, double sigma, int count, RandomStream& random) {
  const auto basis = tangent_basis(plane.normal);
  Eigen::Matrix4d scatter = Eigen::Matrix4d::Zero();
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p = centre - plane.distance(centre) * plane.normal + 4 * (random.next_uniform() - 0.5) * basis.col(0) +
                              2 * (random.next_uniform() - 0.5) * basis.col(1) + sigma * random.next_normal() * plane.normal;
    const Eigen::Vector4d h = p.homogeneous();
    scatter += h * h.transpose();
  }
  return scatter;
}

TEST(PlaneFit, RecoversExactPlanes) {
  RandomStream random(1, 0);
  for (int i = 0; i < 100; ++i) {
    const Plane truth{gaussian(random).normalized(), 5 * random.next_normal()};
    const PlaneFit fit = fit_plane(patch(truth, 10 * gaussian(random), 0, 40, random));
    ASSERT_TRUE(fit.valid);
    const double sign = fit.plane.normal.dot(truth.normal) > 0 ? 1 : -1;
    EXPECT_LT((sign * fit.plane.normal - truth.normal).norm(), 1e-6);
    EXPECT_NEAR(sign * fit.plane.d, truth.d, 1e-4);
    EXPECT_LT(fit.spread[0], 1e-5);
    EXPECT_GT(fit.spread[1], 0.3);
    EXPECT_GT(fit.spread[2], 0.7);
  }
}

TEST(PlaneFit, NoOtherPlaneIsNearerToThePoints) {
  RandomStream random(2, 0);
  for (int i = 0; i < 50; ++i) {
    const Plane truth{gaussian(random).normalized(), random.next_normal()};
    const Eigen::Matrix4d scatter = patch(truth, 3 * gaussian(random), 0.05, 60, random);
    const PlaneFit fit = fit_plane(scatter);
    const double best = mean_squared_distance(scatter, fit.plane);
    EXPECT_NEAR(best, fit.spread[0] * fit.spread[0], 1e-9);
    for (int k = 0; k < 10; ++k) {
      const Plane other{(fit.plane.normal + 0.01 * gaussian(random)).normalized(), fit.plane.d + 0.005 * random.next_normal()};
      EXPECT_GE(mean_squared_distance(scatter, other), best);
    }
  }
}

TEST(PlaneFit, CovarianceIsThatOfRepeatedFits) {
  // 400 fits to the same wall, 3 m beside the origin, so that d and the angles go together: the mean of e^T C^-1 e is 3 with a deviation of 0.12.
  RandomStream random(3, 0);
  const Plane truth{Eigen::Vector3d(0.6, 0.8, 0.0), 2.5};
  const auto basis = tangent_basis(truth.normal);
  double sum = 0;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Matrix4d scatter = patch(truth, Eigen::Vector3d(1, -4, 0.5), 0.02, 80, random);
    Plane fit = fit_plane(scatter).plane;
    if (fit.normal.dot(truth.normal) < 0) fit = {-fit.normal, -fit.d};
    Eigen::Vector3d error;
    error << basis.transpose() * fit.normal, fit.d - truth.d;
    sum += error.dot(plane_covariance(truth, scatter, 0.02).inverse() * error);
  }
  EXPECT_NEAR(sum / 400, 3.0, 0.5);
}

TEST(PlaneFit, RefusesPointsThatHoldNoPlane) {
  EXPECT_FALSE(fit_plane(Eigen::Matrix4d::Zero()).valid);
  Eigen::Matrix4d line = Eigen::Matrix4d::Zero();
  Eigen::Matrix4d point = Eigen::Matrix4d::Zero();
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector4d on_line = (Eigen::Vector3d(1, 2, 3) + 0.1 * i * Eigen::Vector3d(1, 1, 0)).homogeneous();
    line += on_line * on_line.transpose();
    const Eigen::Vector4d same = Eigen::Vector3d(1, 2, 3).homogeneous();
    point += same * same.transpose();
  }
  EXPECT_FALSE(fit_plane(line).valid);
  EXPECT_FALSE(fit_plane(point).valid);
}

}  // namespace
}  // namespace sgraph
