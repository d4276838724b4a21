#include "sgraph_slam/core/odometry/window_solver.hpp"

#include <gtest/gtest.h>

#include <random>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"

namespace sgraph {
namespace {

using Eigen::Vector3d;

constexpr double loose = 1e3;

struct Room {
  SurfaceMap map{SurfaceMapParams{}};
  std::vector<std::pair<Vector3d, Vector3d>> points;  // and their surfaces' normals
};

// A room of 6 x 4 x 2.5 m around the origin, or without its ends a piece of a corridor along x.
Room room(bool ends) {
  Room room;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-0.5, 0.5);
  std::normal_distribution<double> noise(0, 0.005);
  for (int i = 0; i < 42000; ++i) {
    const double a = unit(random);
    const double b = unit(random);
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    Vector3d p(6 * a, side * 2.0, 2.5 * b);
    Vector3d n(0, -side, 0);
    if (i % 3 == 1) p = {6 * a, 4 * b, side * 1.25}, n = {0, 0, -side};
    if (ends && i % 3 == 2) p = {side * 3.0, 4 * a, 2.5 * b}, n = {-side, 0, 0};
    if (i < 40000) {
      room.map.insert(p + noise(random) * n, Vector3d::Zero());
    } else {
      room.points.emplace_back(p, n);
    }
  }
  room.map.update();
  return room;
}

// Two held knots, then two free ones of a sensor that moves at `velocity` [m/s along x], predicted wrongly by `off`.
WindowProblem moving(const Room& room, double velocity, const Pose& off, const VelocityPrior& prior) {
  WindowProblem problem;
  for (int i = 0; i < 4; ++i) problem.knots.push_back({0.05 * i, {Eigen::Quaterniond::Identity(), Vector3d(velocity * 0.05 * i, 0, 0)}});
  problem.first_free = 2;
  problem.prior.assign(4, prior);
  for (std::size_t i = 0; i < room.points.size(); ++i) {
    const double fraction = static_cast<double>(i % 10) / 10;
    const int segment = i < room.points.size() / 2 ? 1 : 2;
    const Pose at = pose_at(problem.knots, 0.05 * (segment + fraction));
    problem.keypoints.push_back({at.inverse() * room.points[i].first, room.points[i].second, segment, fraction});
  }
  for (std::size_t i = 2; i < 4; ++i) problem.knots[i].pose = off * problem.knots[i].pose;
  return problem;
}

TEST(WindowSolver, FindsTheKnotsWithEitherResidual) {
  const Room furnished = room(true);
  const Pose off = se3_exp((Vector6() << 0.01, -0.008, 0.02, 0.03, -0.02, 0.02).finished());
  for (const bool distributions : {false, true}) {
    WindowProblem problem = moving(furnished, 1.0, off, {loose, loose});
    WindowOptions options;
    options.distributions = distributions;
    options.iterations = 15;
    const WindowResult result = solve_window(furnished.map, problem, options);
    EXPECT_GT(result.inlier_share, 0.8) << distributions;
    for (std::size_t i = 2; i < 4; ++i) {
      const Pose expected{Eigen::Quaterniond::Identity(), {0.05 * static_cast<double>(i), 0, 0}};
      const Vector6 error = se3_log(expected.inverse() * problem.knots[i].pose);
      EXPECT_LT(error.head<3>().norm(), 0.003) << distributions;
      EXPECT_LT(error.tail<3>().norm(), 0.005) << distributions;
    }
  }
}

// Without ends the points say nothing of x: what little their Gaussians' errors say must not move the sensor, the prior goes on at the old velocity.
TEST(WindowSolver, LeavesFreeDirectionsToThePrior) {
  const Room corridor = room(false);
  WindowProblem problem = moving(corridor, 1.0, {Eigen::Quaterniond::Identity(), {0, 0.03, 0}}, {0.0009, 0.0015});
  Matrix6 held = Matrix6::Identity();
  held(3, 3) = 0;
  problem.held.assign(3, held);
  solve_window(corridor.map, problem, {});
  EXPECT_NEAR(problem.knots[3].pose.translation.x(), 0.15, 1e-4);
  EXPECT_NEAR(problem.knots[3].pose.translation.y(), 0, 0.005);
}

// A velocity that is said to have changed along y may change along y only.
TEST(WindowSolver, ThePriorGivesWayAlongTheChangeAlone) {
  const Room empty{SurfaceMap{SurfaceMapParams{}}, {}};
  VelocityPrior prior{0.0009, 0.0015};
  prior.moved = {0, 0.05, 0};
  WindowProblem problem = moving(empty, 0, {}, prior);
  MeasuredMotion push;  // another sensor says that it went 2 cm each way
  push.motion.translation = {0.02, 0.02, 0};
  push.information.diagonal().setConstant(1 / (0.005 * 0.005));
  problem.measurements = {{1, push}};
  solve_window(empty.map, problem, {});
  EXPECT_GT(problem.knots[2].pose.translation.y(), 0.018);
  EXPECT_LT(problem.knots[2].pose.translation.x(), 0.008);
}

}  // namespace
}  // namespace sgraph
