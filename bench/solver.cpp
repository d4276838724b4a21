// Solving and marginal covariances of graphs as mapping a building makes them: keyframes along a route through rooms, each seeing the ten planes
// around it; and a hall of racks, in which most keyframes see most of what is far and high.

#include <benchmark/benchmark.h>

#include "sgraph_slam/core/graph/marginals.hpp"
#include "sgraph_slam/core/graph/recent_solver.hpp"
#include "sgraph_slam/core/graph/solver.hpp"
#include "unit/graph/random_graph.hpp"

namespace sgraph {
namespace {

constexpr int planes_a_room = 8;
constexpr int keyframes_a_room = 20;

// A row of rooms, visited to and fro; measurements with noise, the estimate where the last solve left it.
Graph building(int keyframes) {
  test::Draw draw(1);
  const int rooms = std::max(1, keyframes / keyframes_a_room / 2);
  Transaction t;
  for (int r = 0; r < rooms; ++r) {
    const Eigen::Vector3d center(6.0 * r, 0, 1.2);
    for (int p = 0; p < planes_a_room; ++p) {
      const Eigen::Vector3d n = p < 4 ? ((p % 2 == 0 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(p / 2)).eval() : draw.direction();
      t.planes[PlaneId{planes_a_room * r + p}] = Plane{n, 2.5 - n.dot(center)};
    }
    t.rooms[RoomId{r}] = Room::at(center, 0.0, {5.0, 5.0});
  }
  const PlaneId floor{planes_a_room * rooms};
  t.planes[floor] = Plane{Eigen::Vector3d::UnitZ(), 0.0};
  const Vector6 odometry = (Vector6() << 0.003, 0.003, 0.003, 0.01, 0.01, 0.01).finished();
  const Eigen::Vector3d fit(0.005, 0.005, 0.01);
  for (int k = 0; k < keyframes; ++k) {
    const int lap = k / (rooms * keyframes_a_room);
    const double along = static_cast<double>(k % (rooms * keyframes_a_room)) / keyframes_a_room;
    const double at = lap % 2 == 0 ? along : rooms - along;
    t.keyframes[KeyframeId{k}] = Pose{so3_exp(Eigen::Vector3d(0, 0, draw.uniform(-3, 3))), {6.0 * at - 3.0, std::sin(at * 6), 0.5}};
  }
  for (const auto& [k, pose] : t.keyframes) {
    if (k.value > 0) {
      const Pose Z = t.keyframes.at(KeyframeId{k.value - 1}).inverse() * pose * se3_exp(odometry.cwiseProduct(draw.normals<6>()));
      t.factors.push_back({Se3Between{{k.value - 1}, k, Z, SqrtInformation<6>::from_std_dev(odometry)}, {}});
    }
    const int room = std::clamp(static_cast<int>((pose.translation.x() + 3.0) / 6.0), 0, rooms - 1);
    const auto see = [&, &T_map_base = pose, id = k](PlaneId p) {
      const Plane seen = draw.near(T_map_base.inverse() * t.planes.at(p), 0.005, 0.01);
      t.factors.push_back({PosePlane{id, p, seen, Pose{}, SqrtInformation<3>::from_std_dev(fit)}, RobustLoss::huber(2.0)});
    };
    for (int p = 0; p < planes_a_room; ++p) see({planes_a_room * room + p});
    see(floor);
    see({planes_a_room * std::min(room + 1, rooms - 1) + 2});
  }
  const RoomSide sides[] = {RoomSide::x_low, RoomSide::x_high, RoomSide::y_low, RoomSide::y_high};
  for (int r = 0; r < rooms; ++r) {
    for (int side = 0; side < 4; ++side) t.factors.push_back({RoomPlane{{r}, {planes_a_room * r + side}, sides[side]}, {}});
  }
  Graph graph;
  graph.apply(t);
  return graph;
}

// A hall of 60 x 40 m with racks in six aisles, walked up and down: floor, ceiling and outer walls are seen from everywhere, the sides of what stands
// in the racks from the keyframes within reach, also from the next aisle.
Graph hall(int keyframes, int planes) {
  constexpr double reach = 14.0;  // [m]
  test::Draw draw(2);
  Transaction t;
  const Eigen::Vector3d outer[] = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  const double offset[] = {0, 8, 0, 60, 0, 40};
  std::vector<Eigen::Vector3d> at(static_cast<std::size_t>(planes));
  for (int p = 0; p < planes; ++p) {
    if (p < 6) {
      t.planes[PlaneId{p}] = Plane{outer[p], offset[p]};
      continue;
    }
    at[static_cast<std::size_t>(p)] = {draw.uniform(5, 55), 6.0 * draw.below(6) + 6.0, draw.uniform(0, 6)};
    const Eigen::Vector3d n = outer[2 + draw.below(4)];
    t.planes[PlaneId{p}] = Plane{n, -n.dot(at[static_cast<std::size_t>(p)])};
  }
  for (int k = 0; k < keyframes; ++k) {
    const double way = 300.0 * k / keyframes;
    const int aisle = static_cast<int>(way / 50.0);
    const double along = way - 50.0 * aisle;
    const Eigen::Vector3d position(aisle % 2 == 0 ? 5 + along : 55 - along, 6.0 * aisle + 3.0, 0.5);
    t.keyframes[KeyframeId{k}] = Pose{so3_exp(Eigen::Vector3d(0, 0, draw.uniform(-3, 3))), position};
  }
  const Vector6 odometry = (Vector6() << 0.0005, 0.0005, 0.0005, 0.003, 0.003, 0.003).finished();
  const Eigen::Vector3d fit(0.004, 0.004, 0.008);
  for (const auto& [k, pose] : t.keyframes) {
    if (k.value > 0) {
      const Pose Z = t.keyframes.at(KeyframeId{k.value - 1}).inverse() * pose * se3_exp(odometry.cwiseProduct(draw.normals<6>()));
      t.factors.push_back({Se3Between{{k.value - 1}, k, Z, SqrtInformation<6>::from_std_dev(odometry)}, {}});
    }
    for (const auto& [p, plane] : t.planes) {
      if (p.value >= 6 && ((at[static_cast<std::size_t>(p.value)] - pose.translation).norm() > reach || draw.below(3) == 0)) continue;
      const Plane seen = draw.near(pose.inverse() * plane, 0.004, 0.008);
      t.factors.push_back({PosePlane{k, p, seen, Pose{}, SqrtInformation<3>::from_std_dev(fit)}, RobustLoss::huber(2.5)});
    }
  }
  Graph graph;
  graph.apply(t);
  return graph;
}

// As far off as some metres of odometry leave it, all along.
void bend(Graph& graph) {
  test::Draw draw(5);
  Pose drift;
  const auto keyframes = graph.keyframes();
  for (const auto& [id, pose] : keyframes) {
    if (id.value == 0) continue;
    Vector6 step = draw.normals<6>(2e-5);
    step.tail<3>() *= 25.0;
    drift = drift * se3_exp(step);
    graph.set(id, pose * drift);
  }
}

// The newest keyframe is as far off as odometry leaves it.
void disturb_newest(Graph& graph) {
  const auto& [id, pose] = *graph.keyframes().rbegin();
  graph.set(id, pose * Pose{so3_exp(Eigen::Vector3d(0.002, -0.003, 0.004)), {0.01, -0.01, 0.005}});
}

void solve_global(benchmark::State& state) {
  Graph solved = building(static_cast<int>(state.range(0)));
  solve(solved, {});
  disturb_newest(solved);
  SolveSummary summary;
  for (auto _ : state) {
    Graph graph = solved;
    summary = solve(graph, {});
  }
  state.counters["factors"] = summary.factors;
  state.counters["iterations"] = summary.iterations;
}
BENCHMARK(solve_global)->Arg(100)->Arg(500)->Arg(1000)->Unit(benchmark::kMillisecond);

void solve_window(benchmark::State& state) {
  Graph solved = building(static_cast<int>(state.range(0)));
  solve(solved, {});
  disturb_newest(solved);
  const SolveScope scope = recent_window(solved, 20);
  SolveSummary summary;
  for (auto _ : state) {
    Graph graph = solved;
    summary = solve(graph, {}, scope);
  }
  state.counters["factors"] = summary.factors;
  state.counters["iterations"] = summary.iterations;
}
BENCHMARK(solve_window)->Arg(100)->Arg(500)->Arg(1000)->Unit(benchmark::kMillisecond);

// range(0): keyframes, range(1): planes, range(2): StepSolver.
void solve_hall(benchmark::State& state) {
  Graph bent = hall(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  bend(bent);
  SolverOptions options;
  options.steps = static_cast<StepSolver>(state.range(2));
  SolveSummary summary;
  for (auto _ : state) {
    Graph graph = bent;
    summary = solve(graph, options);
  }
  state.counters["factors"] = summary.factors;
  state.counters["iterations"] = summary.iterations;
  state.counters["cost"] = summary.final_cost;
}
BENCHMARK(solve_hall)
    ->ArgsProduct({{100, 250, 465}, {848}, {static_cast<long>(StepSolver::direct), static_cast<long>(StepSolver::iterative)}})
    ->Args({2000, 848, static_cast<long>(StepSolver::iterative)})
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);

// The newest eight keyframes of a hall: range(0) 0: from all factors of their planes, 1: with what older keyframes saw kept as sums.
void solve_newest_in_hall(benchmark::State& state) {
  Graph solved = hall(465, 848);
  SolverOptions options;
  options.max_iterations = 4;
  RecentSolver recent;
  recent.solve(solved, 8, options);
  for (auto _ : state) state.range(0) == 0 ? solve(solved, options, recent_window(solved, 8)) : recent.solve(solved, 8, options);
}
BENCHMARK(solve_newest_in_hall)->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

void marginals_of_hall(benchmark::State& state) {
  const Graph graph = hall(465, 848);
  const VariableId newest = graph.keyframes().rbegin()->first;
  for (auto _ : state) {
    const Marginals marginals(graph, static_cast<MarginalsMethod>(state.range(0)));
    for (int p = 0; p < 10; ++p) benchmark::DoNotOptimize(marginals.joint({newest, PlaneId{80 * p}}));
  }
}
BENCHMARK(marginals_of_hall)
    ->Arg(static_cast<long>(MarginalsMethod::exact))
    ->Arg(static_cast<long>(MarginalsMethod::coarse))
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1);

void copy_graph(benchmark::State& state) {
  const Graph graph = building(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    Graph copy = graph;
    benchmark::DoNotOptimize(copy);
  }
}
BENCHMARK(copy_graph)->Arg(500)->Unit(benchmark::kMillisecond);

void marginals_factorize(benchmark::State& state) {
  const Graph graph = building(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const Marginals marginals(graph);
    benchmark::DoNotOptimize(marginals.ok());
  }
}
BENCHMARK(marginals_factorize)->Arg(100)->Arg(500)->Arg(1000)->Unit(benchmark::kMillisecond);

void marginals_of_all_planes(benchmark::State& state) {
  const Graph graph = building(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const Marginals marginals(graph);
    for (const auto& [id, plane] : graph.planes()) benchmark::DoNotOptimize(marginals.covariance(id));
  }
}
BENCHMARK(marginals_of_all_planes)->Arg(100)->Arg(500)->Arg(1000)->Unit(benchmark::kMillisecond);

// What associating a new keyframe with the planes around it asks for.
void marginals_of_newest_with_ten_planes(benchmark::State& state) {
  const Graph graph = building(static_cast<int>(state.range(0)));
  const VariableId newest = graph.keyframes().rbegin()->first;
  for (auto _ : state) {
    const Marginals marginals(graph);
    int count = 0;
    for (const auto& [id, plane] : graph.planes()) {
      if (++count > 10) break;
      benchmark::DoNotOptimize(marginals.joint({newest, id}));
    }
  }
}
BENCHMARK(marginals_of_newest_with_ten_planes)->Arg(100)->Arg(500)->Arg(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sgraph
