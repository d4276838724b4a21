#include "sgraph_slam/core/odometry/window_solver.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <gtest/gtest.h>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/math/so3.hpp"
#include "support/noisy_box.hpp"

namespace sgraph {
namespace {

using Eigen::Vector3d;

constexpr double loose = 1e3;

struct Room {
  SurfaceMap map{SurfaceMapParams{}};
  std::vector<test::SidePoint> points;
};

// A room of 6 x 4 x 2.5 m around the origin, or without its ends a piece of a corridor along x: the map of noisy points, and others that are exact.
Room room(bool ends) {
  const Vector3d size(6, 4, 2.5);
  Room room;
  for (const test::SidePoint& point : test::noisy_box(size, {true, ends}, 40000, 0.005, 1)) room.map.insert(point.position, Vector3d::Zero());
  room.map.update();
  room.points = test::noisy_box(size, {true, ends}, 2000, 0, 2);
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
    problem.keypoints.push_back({at.inverse() * room.points[i].position, room.points[i].normal, segment, fraction});
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
// With one segment a scan the newest scan's points are those of the last segment alone.
TEST(WindowSolver, JudgesByTheNewestScansPointsAlone) {
  const Room furnished = room(true);
  WindowProblem problem = moving(furnished, 1.0, {}, {0.001, 0.001});
  for (Keypoint& point : problem.keypoints) {
    point.newest = point.segment == 2;
    if (!point.newest) point.p_lidar *= 0.5;
  }
  const WindowResult result = solve_window(furnished.map, problem, {});
  EXPECT_GT(result.inlier_share, 0.8);
  EXPECT_GT(result.agreement, 0.8);
}

TEST(WindowSolver, LeavesFreeDirectionsToThePrior) {
  const Room corridor = room(false);
  WindowProblem problem = moving(corridor, 1.0, {Eigen::Quaterniond::Identity(), {0, 0.03, 0}}, {0.0009, 0.0015});
  Matrix6 held = Matrix6::Identity();
  held(3, 3) = 0;
  problem.observable.assign(3, held);
  solve_window(corridor.map, problem, {});
  EXPECT_NEAR(problem.knots[3].pose.translation.x(), 0.15, 1e-4);
  EXPECT_NEAR(problem.knots[3].pose.translation.y(), 0, 0.005);
}

// A velocity that is said to have changed along y may change along y only.
TEST(WindowSolver, ThePriorGivesWayAlongTheChangeAlone) {
  const Room empty{SurfaceMap{SurfaceMapParams{}}, {}};
  VelocityPrior prior{0.0009, 0.0015};
  prior.translated = {0, 0.05, 0};
  WindowProblem problem = moving(empty, 0, {}, prior);
  MeasuredMotion push;  // another sensor says that it went 2 cm each way
  push.motion.translation = {0.02, 0.02, 0};
  push.information.diagonal().setConstant(1 / (0.005 * 0.005));
  problem.measurements = {{1, push}};
  solve_window(empty.map, problem, {});
  EXPECT_GT(problem.knots[2].pose.translation.y(), 0.018);
  EXPECT_LT(problem.knots[2].pose.translation.x(), 0.008);
}

// Where no point tells anything the sensor goes on as it went, in its own axes: along the arc that it was on.
TEST(WindowSolver, AMotionGoesOnAlongItsArc) {
  const Room empty{SurfaceMap{SurfaceMapParams{}}, {}};
  WindowProblem problem = moving(empty, 0, {}, {0.0009, 0.0015});
  const Vector6 step = (Vector6() << 0, 0, 0.1, 0.05, 0, 0).finished();  // 2 rad/s, 1 m/s
  for (int i = 0; i < 4; ++i) problem.knots[static_cast<std::size_t>(i)].pose = se3_exp(std::min(i, 1) * step);
  solve_window(empty.map, problem, {});
  for (int i = 2; i < 4; ++i) {
    const Pose error = se3_exp(i * step).inverse() * problem.knots[static_cast<std::size_t>(i)].pose;
    EXPECT_LT(error.translation.norm(), 1e-4) << i;
    EXPECT_LT(so3_log(error.rotation).norm(), 1e-4) << i;
  }
}

// Low stripes of wall that lean by 2 degrees in the map, as they do by chance: stood up, they leave the sensor upright.
TEST(WindowSolver, PlumbWallsHoldTheSensorUpright) {
  const auto stripe = [](int count, double noise, std::uint32_t seed) {
    std::vector<test::SidePoint> points = test::noisy_box({6, 4, 2.5}, {true, true}, count, noise, seed);
    const auto outside = [](const test::SidePoint& p) { return std::abs(p.normal.z()) > 0.5 || std::abs(p.position.z()) > 0.25; };
    points.erase(std::remove_if(points.begin(), points.end(), outside), points.end());
    return points;
  };
  const Eigen::Quaterniond lean = so3_exp({0.035, 0, 0});
  Room leaning{SurfaceMap{SurfaceMapParams{}}, stripe(8000, 0, 2)};
  for (const test::SidePoint& point : stripe(80000, 0.005, 1)) leaning.map.insert(lean * point.position, Vector3d::Zero());
  leaning.map.update();
  const auto tilt = [&](bool plumb) {
    WindowProblem problem = moving(leaning, 0, {}, {loose, loose});
    WindowOptions options;
    options.plumb = plumb;
    solve_window(leaning.map, problem, options);
    return std::abs(so3_log(problem.knots[3].pose.rotation).x());
  };
  EXPECT_GT(tilt(false), 0.02);
  EXPECT_LT(tilt(true), 0.005);
}

}  // namespace
}  // namespace sgraph
