#include <benchmark/benchmark.h>

#include "sgraph_slam/core/sim/simulator.hpp"

namespace {

using namespace sgraph;

// One scan of a box in motion: 28 900 rays.
void simulated_scan(benchmark::State& state) {
  const sim::World world = sim::box_world(12, 8, 2.8, {{-4, -2}, {4, -2}, {4, 2}});
  const sim::SimulatedSource source(world, {});
  int number = 0;
  for (auto _ : state) benchmark::DoNotOptimize(source.lidar().scan(40 + number++ % 60));
  state.counters["x real time"] = benchmark::Counter(static_cast<double>(state.iterations()) * 0.1, benchmark::Counter::kIsRate);
}
BENCHMARK(simulated_scan)->Unit(benchmark::kMillisecond);

}  // namespace
