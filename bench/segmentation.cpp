#include <benchmark/benchmark.h>

#include <cmath>

#include "sgraph_slam/core/math/so3.hpp"
#include "sgraph_slam/core/segmentation/plane_segmenter.hpp"
#include "support/static_scan.hpp"

namespace sgraph {
namespace {

// Two rooms with a door between them and some furniture.
sim::Scene rooms() {
  std::vector<sim::Surface> surfaces = test::box({-5, -3, 0}, {5, 3, 2.8});
  for (const auto& piece :
       {test::box({-0.15, 0.5, 0}, {0, 3, 2.8}), test::box({-0.15, -3, 0}, {0, -0.5, 2.8}), test::box({1, 2.5, 0}, {2.5, 2.99, 2}),
        test::box({3, -2, 0.72}, {4.5, -1, 0.75}), test::box({-4, -1, 0}, {-3.2, 1, 0.9})}) {
    surfaces.insert(surfaces.end(), piece.begin(), piece.end());
  }
  return sim::Scene(surfaces);
}

// A keyframe of so many scans, 7.5 cm apart.
void keyframe(benchmark::State& state) {
  std::vector<Pose> poses;
  for (int k = 0; k < state.range(0); ++k) {
    poses.push_back({so3_exp(Eigen::Vector3d(0.01 * std::sin(k), 0.012 * std::cos(k), 0.02 * k)), {1.0 + 0.075 * k, 0.2, 0.9}});
  }
  const Cloud scan = test::keyframe_scan(rooms(), poses, 0.02, 1);
  const PlaneSegmenter segmenter({});
  std::size_t planes = 0;
  for (auto _ : state) {
    const PlaneSegments result = segmenter.process(scan);
    planes = result.segments.size();
    benchmark::DoNotOptimize(planes);
  }
  state.counters["points"] = static_cast<double>(scan.size());
  state.counters["planes"] = static_cast<double>(planes);
}
BENCHMARK(keyframe)->Arg(1)->Arg(10)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sgraph
