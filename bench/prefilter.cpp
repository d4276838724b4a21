#include "sgraph_slam/core/prefilter/prefilter.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace sgraph {
namespace {

// 28 800 points of a VLP-16 at 10 Hz in a room of 8 x 6 x 2.8 m, column by column.
Cloud room_scan() {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.02);
  Cloud cloud;
  for (int column = 0; column < 1800; ++column) {
    for (int ring = 0; ring < 16; ++ring) {
      const double azimuth = -2 * M_PI * column / 1800, elevation = (-15 + 2 * ring) * M_PI / 180;
      const double x = std::cos(elevation) * std::cos(azimuth), y = std::cos(elevation) * std::sin(azimuth), z = std::sin(elevation);
      const double range =
          std::min({(x > 0 ? 5 : 3) / std::abs(x), (y > 0 ? 2.5 : 3.5) / std::abs(y), (z > 0 ? 2.1 : 0.7) / std::abs(z)}) + noise(random);
      Point p;
      p.x = static_cast<float>(range * x);
      p.y = static_cast<float>(range * y);
      p.z = static_cast<float>(range * z);
      p.ring = static_cast<std::uint16_t>(ring);
      cloud.points.push_back(p);
    }
  }
  return cloud;
}

void run(benchmark::State& state, const PrefilterParams& params) {
  const Cloud raw = room_scan();
  const Prefilter prefilter(params);
  int kept = 0;
  for (auto _ : state) {
    const FilteredScan scan = prefilter.process(raw);
    kept = scan.counts.kept;
    benchmark::DoNotOptimize(scan.cloud);
  }
  state.counters["points"] = static_cast<double>(raw.size());
  state.counters["kept"] = kept;
}

void defaults(benchmark::State& state) { run(state, {}); }
BENCHMARK(defaults)->Unit(benchmark::kMillisecond);

void sigma_interval(benchmark::State& state) {
  PrefilterParams params;
  params.range_sigmas = 3;
  run(state, params);
}
BENCHMARK(sigma_interval)->Unit(benchmark::kMillisecond);

void radius_outliers(benchmark::State& state) {
  PrefilterParams params;
  params.outliers = "radius";
  run(state, params);
}
BENCHMARK(radius_outliers)->Unit(benchmark::kMillisecond);

void statistical_outliers(benchmark::State& state) {
  PrefilterParams params;
  params.outliers = "statistical";
  params.outlier_neighbours = 20;
  run(state, params);
}
BENCHMARK(statistical_outliers)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sgraph
