#include "sgraph_slam/core/graph/solver.hpp"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <fstream>

#include "factor_cases.hpp"
#include "sgraph_slam/core/graph/g2o.hpp"
#include "sgraph_slam/core/graph/marginals.hpp"
#include "sgraph_slam/core/graph/recent_solver.hpp"

namespace sgraph::test {
namespace {

const Pose T_base_lidar{so3_exp(Eigen::Vector3d(0.02, -0.03, 0.5)), {0.1, 0.0, 0.4}};
const Vector6 odometry_sigma = (Vector6() << 0.005, 0.005, 0.005, 0.02, 0.02, 0.02).finished();
const Eigen::Vector3d plane_sigma(0.01, 0.01, 0.02);

// A robot driving round in a room of 6 x 4 m, floor included, 37 degrees to the map; `noise` scales the measurements' errors.
struct World {
  explicit World(unsigned seed, double noise, bool with_room = true, int laps = 1) : draw(seed) {
    room = Room::at({1.0, -2.0, 1.2}, 0.65, {6.0, 4.0});
    for (int k = 0; k < 8 * laps; ++k) {
      const double turn = 2 * M_PI * k / 8;
      const Eigen::Vector3d at = room.center() + 1.5 * std::cos(turn) * room.axis(0) + std::sin(turn) * room.axis(1) - Eigen::Vector3d(0, 0, 0.7);
      truth.keyframes[KeyframeId{k}] = Pose{so3_exp(Eigen::Vector3d(0, 0, turn)) * so3_exp(draw.normals<3>(0.02)), at};
    }
    for (int side = 0; side < 4; ++side) {
      const Eigen::Vector3d n = (side % 2 == 0 ? 1.0 : -1.0) * room.axis(side / 2);
      const Eigen::Vector3d foot = room.center() - 0.5 * room.width[side / 2] * n;
      truth.planes[PlaneId{side}] = Plane{n, -n.dot(foot)};
    }
    truth.planes[PlaneId{4}] = Plane{Eigen::Vector3d::UnitZ(), 0.0};
    if (with_room) truth.rooms[RoomId{0}] = room;
    EXPECT_TRUE(graph.apply(truth).ok());
    Transaction t;
    for (const auto& [k, pose] : truth.keyframes) {
      if (k.value > 0) {
        const KeyframeId last{k.value - 1};
        const Pose measured = truth.keyframes.at(last).inverse() * pose * se3_exp(noise * odometry_sigma.cwiseProduct(draw.normals<6>()));
        t.factors.push_back({Se3Between{last, k, measured, SqrtInformation<6>::from_std_dev(odometry_sigma)}, {}});
      }
      for (const auto& [p, plane] : truth.planes) {
        if (p.value < 4 && (k.value + p.value) % 3 == 0) continue;  // not every wall from everywhere
        t.factors.push_back({observation(k, p, noise), {}});
      }
    }
    const RoomSide sides[] = {RoomSide::x_low, RoomSide::x_high, RoomSide::y_low, RoomSide::y_high};
    for (int side = 0; with_room && side < 4; ++side) t.factors.push_back({RoomPlane{{0}, {side}, sides[side], 0.01}, {}});
    EXPECT_TRUE(graph.apply(t).ok());
  }

  PosePlane observation(KeyframeId k, PlaneId p, double noise) {
    const Plane seen = (truth.keyframes.at(k) * T_base_lidar).inverse() * truth.planes.at(p);
    const Eigen::Vector3d error = noise * plane_sigma.cwiseProduct(draw.normals<3>());
    const Plane measured{(seen.normal + tangent_basis(seen.normal) * error.head<2>()).normalized(), seen.d + error[2]};
    return {k, p, measured, T_base_lidar, SqrtInformation<3>::from_std_dev(plane_sigma)};
  }

  void disturb(double sigma) {
    for (const auto& [id, pose] : truth.keyframes) {
      if (id.value > 0) graph.set(id, draw.near(pose, sigma));
    }
    for (const auto& [id, plane] : truth.planes) graph.set(id, draw.near(plane, sigma, sigma));
    for (const auto& [id, r] : truth.rooms) {
      Room moved = r;
      moved.position += draw.normals<2>(sigma);
      moved.width += draw.normals<2>(sigma);
      graph.set(id, moved);
    }
  }

  // Error in the tangent space of variables.hpp.
  Eigen::VectorXd error(const VariableId& id) const {
    if (const auto* k = std::get_if<KeyframeId>(&id)) return se3_log(truth.keyframes.at(*k).inverse() * *graph.find(*k));
    if (const auto* p = std::get_if<PlaneId>(&id)) {
      Eigen::Vector3d e;
      e << tangent_basis(graph.find(*p)->normal).transpose() * (graph.find(*p)->normal - truth.planes.at(*p).normal),
          graph.find(*p)->d - truth.planes.at(*p).d;
      return e;
    }
    const Room& r = *graph.find(std::get<RoomId>(id));
    Eigen::Vector4d e;
    e << r.position - room.position, r.width - room.width;
    return e;
  }

  double worst_error() const {
    double worst = 0;
    for (const auto& [id, value] : truth.keyframes) worst = std::max(worst, error(id).norm());
    for (const auto& [id, value] : truth.planes) worst = std::max(worst, error(id).norm());
    for (const auto& [id, value] : truth.rooms) worst = std::max(worst, error(id).norm());
    return worst;
  }

  Draw draw;
  Room room;
  Transaction truth;
  Graph graph;
};

SolverOptions exact() {
  SolverOptions options;
  options.max_iterations = 100;
  options.function_tolerance = 1e-14;
  options.parameter_tolerance = 1e-14;
  return options;
}

TEST(Solver, RecoversTheTruthFromExactMeasurements) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    World world(seed, 0.0);
    world.disturb(0.15);
    const Pose first = *world.graph.find(KeyframeId{0});
    ASSERT_GT(world.worst_error(), 0.1);
    const SolveSummary summary = solve(world.graph, exact());
    EXPECT_TRUE(summary.converged);
    EXPECT_LT(summary.final_cost, 1e-12);
    EXPECT_LT(world.worst_error(), 1e-6);
    EXPECT_EQ(world.graph.find(KeyframeId{0})->translation, first.translation);  // gauge, to the bit
    EXPECT_EQ(summary.keyframes, 7);
    EXPECT_EQ(summary.planes, 5);
    EXPECT_EQ(summary.factors, static_cast<int>(world.graph.factors().size()));
  }
}

// The graph of a World solved by Ceres.
Graph solved_by_ceres(const Graph& graph) {
  Graph out = graph;
  std::map<VariableId, std::vector<double>> x;
  ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>> poses;
  ceres::ProductManifold<ceres::SphereManifold<3>, ceres::EuclideanManifold<1>> planes;
  ceres::Problem::Options options;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(options);
  for (const auto& [id, pose] : graph.keyframes()) {
    const Eigen::Vector4d q = pose.rotation.coeffs();
    x[id] = {q[0], q[1], q[2], q[3], pose.translation.x(), pose.translation.y(), pose.translation.z()};
    problem.AddParameterBlock(x[id].data(), 7, &poses);
  }
  for (const auto& [id, plane] : graph.planes()) {
    x[id] = {plane.normal.x(), plane.normal.y(), plane.normal.z(), plane.d};
    problem.AddParameterBlock(x[id].data(), 4, &planes);
  }
  for (const auto& [id, room] : graph.rooms()) x[id] = {room.position.x(), room.position.y(), room.width.x(), room.width.y()};
  problem.SetParameterBlockConstant(x.begin()->second.data());
  for (const auto& [id, factor] : graph.factors()) {
    std::vector<double*> of_factor;
    for (const VariableId& variable : blocks(factor.data)) of_factor.push_back(x.at(variable).data());
    ceres::LossFunction* loss = factor.loss.kind == LossKind::huber ? new ceres::HuberLoss(factor.loss.scale) : nullptr;
    problem.AddResidualBlock(cost_of({graph, factor}).release(), loss, of_factor);
  }
  ceres::Solver::Options how;
  how.max_num_iterations = 100;
  how.function_tolerance = how.parameter_tolerance = 1e-14;
  how.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  ceres::Solver::Summary summary;
  ceres::Solve(how, &problem, &summary);
  for (const auto& [id, v] : x) {
    if (const auto* k = std::get_if<KeyframeId>(&id)) out.set(*k, Pose{Eigen::Quaterniond(v[3], v[0], v[1], v[2]).normalized(), {v[4], v[5], v[6]}});
    if (const auto* p = std::get_if<PlaneId>(&id)) out.set(*p, Plane{Eigen::Vector3d(v[0], v[1], v[2]).normalized(), v[3]});
    if (const auto* r = std::get_if<RoomId>(&id)) {
      Room room = *graph.find(*r);
      room.position = {v[0], v[1]};
      room.width = {v[2], v[3]};
      out.set(*r, room);
    }
  }
  return out;
}

double farthest(const Graph& a, const Graph& b) {
  double worst = 0;
  for (const auto& [id, pose] : a.keyframes()) worst = std::max(worst, se3_log(pose.inverse() * *b.find(id)).norm());
  for (const auto& [id, plane] : a.planes()) {
    worst = std::max({worst, (plane.normal - b.find(id)->normal).norm(), std::abs(plane.d - b.find(id)->d)});
  }
  return worst;
}

// Some observations are an arm's length off, and a loss lets go of them.
void spoil(World& world) {
  Transaction t;
  for (const auto& [id, factor] : world.graph.factors()) {
    const auto* view = std::get_if<PosePlane>(&factor.data);
    if (view == nullptr) continue;
    t.remove_factors.push_back(id);
    Factor spoilt = factor;
    spoilt.loss = RobustLoss::huber(2.5);
    if (id.value % 9 == 0) std::get<PosePlane>(spoilt.data).measured.d += 0.5;
    t.factors.push_back(spoilt);
  }
  ASSERT_TRUE(world.graph.apply(t).ok());
}

TEST(Solver, FindsTheMinimumThatCeresFinds) {
  for (unsigned seed = 20; seed < 26; ++seed) {
    World world(seed, 1.0, true, 1 + static_cast<int>(seed % 3));
    if (seed % 2 == 0) spoil(world);
    world.disturb(0.05);
    const Graph reference = solved_by_ceres(world.graph);
    for (const StepSolver steps : {StepSolver::direct, StepSolver::iterative}) {
      Graph graph = world.graph;
      SolverOptions options = exact();
      options.steps = steps;
      EXPECT_TRUE(solve(graph, options).converged);
      EXPECT_NEAR(total_cost(graph), total_cost(reference), 1e-9 * total_cost(reference));
      EXPECT_LT(farthest(graph, reference), 1e-6) << seed;
    }
  }
}

TEST(Solver, IterativeStepsNeedNoMoreOfThemThanDirectOnes) {
  for (const int laps : {2, 6, 20}) {
    World world(3, 1.0, true, laps);
    world.disturb(0.05);
    Graph direct = world.graph;
    Graph iterative = world.graph;
    SolverOptions options;
    options.steps = StepSolver::direct;
    const SolveSummary by_direct = solve(direct, options);
    options.steps = StepSolver::iterative;
    const SolveSummary by_iterative = solve(iterative, options);
    EXPECT_TRUE(by_iterative.converged);
    EXPECT_LE(by_iterative.iterations, by_direct.iterations + 2);
    EXPECT_NEAR(by_iterative.final_cost, by_direct.final_cost, 1e-4 * by_direct.final_cost);
  }
}

TEST(RecentSolver, MovesWhatAWindowMoves) {
  // Two maps that grow alike; losses are left out, so that sums over views are exact.
  World whole(9, 1.0, true, 6);
  whole.disturb(0.01);
  Graph by_window;
  Graph by_sums;
  RecentSolver recent;
  Transaction first;
  first.planes = whole.graph.planes();
  first.rooms = whole.graph.rooms();
  for (const auto& [id, factor] : whole.graph.factors()) {
    if (std::holds_alternative<RoomPlane>(factor.data)) first.factors.push_back(factor);
  }
  ASSERT_TRUE(by_window.apply(first).ok() && by_sums.apply(first).ok());
  for (const auto& [id, pose] : whole.graph.keyframes()) {
    Transaction t;
    t.keyframes[id] = pose;
    for (const FactorId factor : whole.graph.factors_of(id)) {
      const FactorData& data = whole.graph.find(factor)->data;
      const auto* between = std::get_if<Se3Between>(&data);
      if (between == nullptr || between->to == id) t.factors.push_back(*whole.graph.find(factor));
    }
    if (id.value == 30) t.merges.push_back({PlaneId{2}, PlaneId{4}});  // whatever they are: views change hands
    if (id.value == 36) t.undo_merges.push_back(PlaneId{4});
    const bool applied = by_window.apply(t).ok();
    ASSERT_EQ(by_sums.apply(t).ok(), applied);
    if (!applied) {
      t.merges.clear();
      t.undo_merges.clear();
      ASSERT_TRUE(by_window.apply(t).ok() && by_sums.apply(t).ok());
    }
    if (id.value % 17 == 16) {
      solve(by_window, exact());
      solve(by_sums, exact());
    }
    const SolveSummary a = solve(by_window, exact(), recent_window(by_window, 5));
    const SolveSummary b = recent.solve(by_sums, 5, exact());
    ASSERT_EQ(a.keyframes, b.keyframes);
    ASSERT_EQ(a.planes, b.planes);
    ASSERT_EQ(a.factors, b.factors) << id.value;
    ASSERT_LT(farthest(by_window, by_sums), 1e-6) << id.value;
  }
}

TEST(Solver, PointsFormRecoversTheTruthToo) {
  World world(3, 0.0, false);
  Transaction t;
  for (const auto& [id, factor] : world.graph.factors()) {
    const auto* observation = std::get_if<PosePlane>(&factor.data);
    if (observation == nullptr) continue;
    t.remove_factors.push_back(id);
    const SqrtScatter points = sqrt_scatter(world.draw.scatter(observation->measured, 0.0, 200), 0.02, 0.001, 0.003);
    t.factors.push_back({PosePlanePoints{observation->keyframe, observation->plane, points, T_base_lidar}, {}});
  }
  ASSERT_TRUE(world.graph.apply(t).ok());
  world.disturb(0.1);
  EXPECT_TRUE(solve(world.graph, exact()).converged);
  EXPECT_LT(world.worst_error(), 1e-5);
}

TEST(Solver, SameInputSameBits) {
  World a(5, 1.0);
  World b(5, 1.0);
  a.disturb(0.05);
  b.disturb(0.05);
  solve(a.graph, {});
  solve(b.graph, {});
  EXPECT_TRUE(a.graph == b.graph);
}

TEST(Solver, RoomFactorsAloneTellPosesNothing) {
  World with(6, 1.0, true);
  World without(6, 1.0, false);
  solve(with.graph, exact());
  solve(without.graph, exact());
  for (const auto& [id, pose] : without.graph.keyframes()) {
    EXPECT_LT(se3_log(pose.inverse() * *with.graph.find(id)).norm(), 1e-6);
  }
  // A width measured elsewhere does inform.
  Transaction t;
  t.factors.push_back({RoomWidth{{0}, {0}, 0, 6.1, 0.005}, {}});
  ASSERT_TRUE(with.graph.apply(t).ok());
  solve(with.graph, exact());
  double moved = 0;
  for (const auto& [id, pose] : without.graph.keyframes()) moved = std::max(moved, se3_log(pose.inverse() * *with.graph.find(id)).norm());
  EXPECT_GT(moved, 1e-3);
}

TEST(Solver, AWindowMovesOnlyItsVariables) {
  World world(7, 1.0, true, 3);
  world.disturb(0.02);
  const Graph before = world.graph;
  const SolveScope scope = recent_window(world.graph, 4);
  EXPECT_EQ(scope.free->count(KeyframeId{23}), 1u);
  EXPECT_EQ(scope.free->count(KeyframeId{19}), 0u);
  EXPECT_EQ(scope.free->count(PlaneId{4}), 1u);
  EXPECT_EQ(scope.free->count(RoomId{0}), 1u);
  const SolveSummary summary = solve(world.graph, exact(), scope);
  EXPECT_EQ(summary.keyframes, 4);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  for (const auto& [id, pose] : before.keyframes()) {
    const bool moved = world.graph.find(id)->translation != pose.translation;
    EXPECT_EQ(moved, id.value > 19) << id.value;
  }
}

TEST(Solver, ALossLetsAWrongLoopGo) {
  World world(8, 1.0, false);
  Graph right = world.graph;
  solve(right, exact());
  Transaction t;
  const Pose wrong{so3_exp(Eigen::Vector3d(0, 0, 1.0)), {3, 0, 0}};
  t.factors.push_back(
      {Se3Between{{1}, {6}, wrong, SqrtInformation<6>::from_std_dev(odometry_sigma), Se3Between::Source::loop}, RobustLoss::cauchy(1.0)});
  const FactorId loop = world.graph.apply(t).factors.at(0);
  solve(world.graph, exact());
  for (const auto& [id, pose] : right.keyframes()) EXPECT_LT(se3_log(pose.inverse() * *world.graph.find(id)).norm(), 0.02);
  EXPECT_GT(chi_square(world.graph, world.graph.find(loop)->data), 1000.0);
}

TEST(Solver, AnEmptyGraphAndLooseVariablesAreFine) {
  Graph empty;
  EXPECT_TRUE(solve(empty, {}).converged);
  EXPECT_TRUE(Marginals(empty).ok());
  Transaction t;
  t.keyframes[KeyframeId{4}] = Pose{};
  t.planes[PlaneId{0}] = Plane{};
  Graph loose;
  ASSERT_TRUE(loose.apply(t).ok());
  EXPECT_TRUE(solve(loose, {}).converged);
  EXPECT_FALSE(Marginals(loose).covariance(PlaneId{0}).has_value());
  EXPECT_EQ(Marginals(loose).covariance(KeyframeId{4})->norm(), 0.0);
}

TEST(ChiSquare, MissingVariablesAreInfinitelyFar) {
  World world(1, 0.0);
  EXPECT_TRUE(std::isinf(chi_square(world.graph, PosePlane{{0}, {77}, {}, {}, {}})));
  EXPECT_EQ(weighted_residual(world.graph, PosePlane{{77}, {0}, {}, {}, {}}).size(), 0);
  EXPECT_TRUE(std::isinf(innovation_chi_square(world.graph, Marginals(world.graph), PosePlane{{0}, {77}, {}, {}, {}})));
}

TEST(Marginals, AChainAddsUpAsTheAdjointSays) {
  Draw draw(31);
  for (int i = 0; i < 20; ++i) {
    Transaction t;
    for (int k = 0; k < 3; ++k) t.keyframes[KeyframeId{k}] = draw.pose();
    const Matrix6 first = draw.covariance<6>(0.05);
    const Matrix6 second = draw.covariance<6>(0.05);
    const auto between = [&](int k, const Matrix6& covariance) {
      const Pose Z = t.keyframes.at(KeyframeId{k}).inverse() * t.keyframes.at(KeyframeId{k + 1});
      return Factor{Se3Between{{k}, {k + 1}, Z, SqrtInformation<6>::from_covariance(covariance, Vector6::Constant(1e-6))}, {}};
    };
    t.factors = {between(0, first), between(1, second)};
    Graph graph;
    ASSERT_TRUE(graph.apply(t).ok());
    const Marginals marginals(graph);
    ASSERT_TRUE(marginals.ok());
    const Matrix6 back = se3_adjoint(t.keyframes.at(KeyframeId{2}).inverse() * t.keyframes.at(KeyframeId{1}));
    const Matrix6 expected = back * first * back.transpose() + second;
    EXPECT_LT((*marginals.covariance(KeyframeId{1}) - first).norm(), 1e-8 * first.norm());
    EXPECT_LT((*marginals.covariance(KeyframeId{2}) - expected).norm(), 1e-7 * expected.norm());
    const Eigen::MatrixXd joint = *marginals.joint({KeyframeId{2}, KeyframeId{0}, KeyframeId{1}});
    EXPECT_LT((joint.block<6, 6>(0, 12) - back * first).norm(), 1e-7 * (back * first).norm());
    EXPECT_EQ(joint.middleRows<6>(6).norm(), 0.0);
  }
}

TEST(Marginals, EveryBlockIsThatOfTheDenseInverse) {
  World world(17, 1.0, true, 2);
  solve(world.graph, exact());
  std::vector<VariableId> ids;
  for (const auto& [id, pose] : world.graph.keyframes()) {
    if (id.value > 0) ids.emplace_back(id);
  }
  for (const auto& [id, plane] : world.graph.planes()) ids.emplace_back(id);
  ids.emplace_back(RoomId{0});
  const Marginals marginals(world.graph);
  const Eigen::MatrixXd all = *marginals.joint(ids);
  EXPECT_LT((all - all.transpose()).norm(), 1e-9 * all.norm());
  // Its inverse is the information: no entry between variables that no factor joins, and the room's own is that of its four factors.
  const Eigen::MatrixXd information = all.inverse();
  const double scale = information.cwiseAbs().maxCoeff();
  EXPECT_LT(information.bottomLeftCorner(4, 6 * 15).cwiseAbs().maxCoeff(), 1e-6 * scale);
  Eigen::Matrix4d of_room = Eigen::Matrix4d::Zero();
  for (int side = 0; side < 4; ++side) {
    Eigen::Vector4d j = Eigen::Vector4d::Zero();
    j[side / 2] = side % 2 == 0 ? 1.0 : -1.0;
    j[2 + side / 2] = -0.5;
    of_room += j * j.transpose() / (0.01 * 0.01);
  }
  EXPECT_LT((information.bottomRightCorner(4, 4) - of_room).norm(), 0.01 * of_room.norm());
  Eigen::Index row = 0;
  for (const VariableId& id : ids) {
    const int size = tangent_size(id);
    const Eigen::MatrixXd alone = *Marginals(world.graph).covariance(id);
    EXPECT_LT((alone - all.block(row, row, size, size)).norm(), 1e-8 * alone.norm()) << to_string(id);
    row += size;
  }
}

TEST(Marginals, CoarseOnesAreExactWithAllNodesAndALittleSmallWithFewer) {
  World world(18, 1.0, true, 8);
  Transaction t;
  t.factors.push_back({ParallelPlanes{{0}, {1}}, {}});
  t.factors.push_back({WallThickness{{2}, {4}, 1.0, 0.5}, {}});
  ASSERT_TRUE(world.graph.apply(t).ok());
  solve(world.graph, exact());
  const std::vector<VariableId> ids{KeyframeId{3}, KeyframeId{40}, KeyframeId{62}, PlaneId{0},   PlaneId{2},
                                    PlaneId{3},    PlaneId{4},     RoomId{0},      KeyframeId{0}};
  const Eigen::MatrixXd right = *Marginals(world.graph, MarginalsMethod::exact).joint(ids);
  const Marginals all(world.graph, MarginalsMethod::coarse, 100);
  ASSERT_TRUE(all.ok());
  EXPECT_LT((*all.joint(ids) - right).norm(), 1e-7 * right.norm());
  const Eigen::MatrixXd coarse = *Marginals(world.graph, MarginalsMethod::coarse, 10).joint(ids);
  for (Eigen::Index i = 0; i < right.rows() - 6; ++i) {
    EXPECT_LE(coarse(i, i), right(i, i) * (1 + 1e-6)) << i;
    if (i < 12) continue;  // the two old keyframes are nearly rigid with their neighbours
    EXPECT_GT(coarse(i, i), 0.5 * right(i, i)) << i;
  }
}

TEST(Marginals, ErrorsOfSolvesAreAsLargeAsTheySay) {
  std::map<VariableId, double> sum;
  double innovation = 0;
  const int runs = 150;
  for (int run = 0; run < runs; ++run) {
    World world(static_cast<unsigned>(1000 + run), 1.0);
    ASSERT_TRUE(solve(world.graph, exact()).converged);
    const Marginals marginals(world.graph);
    ASSERT_TRUE(marginals.ok());
    for (const VariableId id : {VariableId(KeyframeId{3}), VariableId(KeyframeId{7}), VariableId(PlaneId{1}), VariableId(PlaneId{4})}) {
      const Eigen::VectorXd e = world.error(id);
      sum[id] += e.dot(marginals.covariance(id)->ldlt().solve(e)) / tangent_size(id);
    }
    // A fresh observation, not yet in the graph.
    innovation += innovation_chi_square(world.graph, marginals, world.observation(KeyframeId{6}, PlaneId{0}, 1.0)) / 3.0;
  }
  // Means of `runs` chi-squares over their degrees of freedom: five standard deviations of room.
  for (const auto& [id, total] : sum) EXPECT_NEAR(total / runs, 1.0, 5 * std::sqrt(2.0 / (runs * tangent_size(id)))) << to_string(id);
  EXPECT_NEAR(innovation / runs, 1.0, 5 * std::sqrt(2.0 / (runs * 3)));
}

TEST(Marginals, UndeterminedVariablesAreSaidSo) {
  Transaction t;
  t.keyframes[KeyframeId{0}] = Pose{};
  t.planes = {{PlaneId{0}, Plane{{1, 0, 0}, 1}}, {PlaneId{1}, Plane{{0, 1, 0}, 1}}};
  t.factors = {{PerpendicularPlanes{{0}, {1}}, {}}};
  Graph graph;
  ASSERT_TRUE(graph.apply(t).ok());
  EXPECT_FALSE(Marginals(graph).ok());
  EXPECT_FALSE(Marginals(graph).covariance(PlaneId{0}).has_value());
}

// A ring of keyframes with loops and full, correlated information matrices.
Graph ring(unsigned seed) {
  Draw draw(seed);
  Transaction t;
  for (int k = 0; k < 30; ++k) {
    const double turn = 2 * M_PI * k / 30;
    t.keyframes[KeyframeId{k}] = Pose{so3_exp(Eigen::Vector3d(0.3 * std::sin(turn), 0, turn)), {8 * std::cos(turn), 8 * std::sin(turn), 0.1 * k}};
  }
  for (int k = 0; k < 30; ++k) {
    for (const int step : {1, 7}) {
      const KeyframeId to{(k + step) % 30};
      t.factors.push_back({Se3Between{{k},
                                      to,
                                      t.keyframes.at({k}).inverse() * t.keyframes.at(to),
                                      draw.weight<6>(),
                                      to.value == k + 1 ? Se3Between::Source::odometry : Se3Between::Source::loop},
                           {}});
    }
  }
  Graph graph;
  EXPECT_TRUE(graph.apply(t).ok());
  return graph;
}

TEST(Chordal, FindsThePosesWithoutAGuess) {
  const Graph truth = ring(1);
  Graph graph = truth;
  for (const auto& [id, pose] : truth.keyframes()) {
    if (id.value > 0) graph.set(id, Pose{});
  }
  initialise_chordal(graph);
  for (const auto& [id, pose] : truth.keyframes()) EXPECT_LT(se3_log(pose.inverse() * *graph.find(id)).norm(), 1e-8) << id.value;
}

TEST(G2o, WritesAndReadsAGraph) {
  const std::string path = testing::TempDir() + "ring.g2o";
  const Graph graph = ring(2);
  write_g2o(path, graph);
  const Graph again = read_g2o(path);
  ASSERT_EQ(again.keyframes().size(), graph.keyframes().size());
  ASSERT_EQ(again.factors().size(), graph.factors().size());
  for (const auto& [id, factor] : graph.factors()) {
    const auto& a = std::get<Se3Between>(factor.data);
    const auto& b = std::get<Se3Between>(again.find(id)->data);
    EXPECT_TRUE(a.from == b.from && a.to == b.to && a.source == b.source);
    EXPECT_LT(se3_log(a.T_from_to.inverse() * b.T_from_to).norm(), 1e-12);
    EXPECT_LT((a.weight.matrix() - b.weight.matrix()).norm(), 1e-6 * a.weight.matrix().norm());
  }
}

TEST(G2o, BadFilesAreRefusedWithTheirLine) {
  const std::string path = testing::TempDir() + "bad.g2o";
  const std::string vertex = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n";
  const std::string edge = "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";
  const auto read = [&](const std::string& text) {
    std::ofstream(path) << text;
    return read_g2o(path);
  };
  EXPECT_EQ(read(vertex + "# a comment\nFIX 0\n" + edge).keyframes().size(), 2u);
  for (const std::string& bad : {vertex + vertex, vertex + "VERTEX_SE3:QUAT 1 0 0 0 0 0 0 0\n", vertex + "EDGE_SE3:QUAT 0 1 1 0 0\n",
                                 vertex + "VERTEX_SE3:QUAT 1 nan 0 0 0 0 0 1\n", vertex + "EDGE_SE2 0 1\n"}) {
    try {
      read(bad + edge);
      ADD_FAILURE() << bad;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find("bad.g2o:2: "), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(read(vertex), std::runtime_error);
  EXPECT_THROW(read_g2o("/nonexistent.g2o"), std::runtime_error);
}

}  // namespace
}  // namespace sgraph::test
