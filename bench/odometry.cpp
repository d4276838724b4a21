// Milliseconds a scan for each step of the odometry, on a stretch of the demonstration world. Run it in the package's folder.
#include <benchmark/benchmark.h>

#include <algorithm>

#include "sgraph_slam/core/math/se3.hpp"
#include "sgraph_slam/core/odometry/odometry.hpp"
#include "sgraph_slam/core/odometry/thinning.hpp"
#include "sgraph_slam/core/odometry/window_solver.hpp"
#include "sgraph_slam/core/prefilter/prefilter.hpp"
#include "sgraph_slam/core/registration/rigid_alignment.hpp"
#include "sgraph_slam/core/sim/simulator.hpp"

namespace sgraph {
namespace {

constexpr int scan_count = 80;
constexpr int mapped = 78;  // the last two are in the window

struct Stretch {
  std::vector<CloudPtr> raw;
  std::vector<CloudPtr> scans;  // prefiltered
  Knots knots;                  // two segments a scan, where the LiDAR was
  Pose T_base_lidar;
  SurfaceMap map{SurfaceMapParams{}};

  Stretch() {
    const auto simulated = sim::simulate_scans(sim::read_world("worlds/demo.yaml"), scan_count, {}, 60);
    T_base_lidar = simulated.T_base_lidar;
    raw = simulated.scans;
    const Prefilter prefilter({});
    for (const CloudPtr& scan : raw) scans.push_back(prefilter.process(*scan).cloud);
    for (int i = -2; i < 2 * scan_count - 1; ++i) {
      const double time = 0.05 * i;
      knots.push_back({time, pose_at(simulated.truth, raw.front()->stamp.after(time)) * T_base_lidar});
    }
    for (int i = 0; i < mapped; ++i) insert(map, i);
  }

  [[nodiscard]] double time(int scan) const { return scans[static_cast<std::size_t>(scan)]->stamp - scans.front()->stamp; }
  [[nodiscard]] CloudPtr deskewed(int scan) const { return deskew(*scans[static_cast<std::size_t>(scan)], time(scan), knots); }
  void insert(SurfaceMap& into, int scan) const {
    const Pose pose = pose_at(knots, time(scan));
    for (const Point& p : deskewed(scan)->points) into.insert(pose * p.position().cast<double>(), pose.translation);
    into.update();
  }
};

const Stretch& stretch() {
  static const Stretch once;
  return once;
}

void prefilter_step(benchmark::State& state) {
  const Stretch& s = stretch();
  const Prefilter prefilter({});
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(prefilter.process(*s.raw[i++ % scan_count]));
}

void thinning_step(benchmark::State& state) {
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(thinned(stretch().scans[i++ % scan_count]->points, MotionParams{}.keypoint_leaf));
}

void rigid_alignment_step(benchmark::State& state) {
  const Stretch& s = stretch();
  std::vector<SeenPoint> points;
  const Pose pose = pose_at(s.knots, s.time(mapped));
  const std::vector<Point> keypoints = thinned(s.deskewed(mapped)->points, MotionParams{}.keypoint_leaf);
  for (std::size_t i = 0; i < keypoints.size(); i += 2) points.push_back({pose * keypoints[i].position().cast<double>(), pose.translation});
  RigidAlignmentOptions options;
  options.start.translation = {0.03, -0.02, 0.01};
  for (auto _ : state) benchmark::DoNotOptimize(align_rigidly(s.map, points, options));
  state.counters["points"] = static_cast<double>(points.size());
}

void window_step(benchmark::State& state) {
  const Stretch& s = stretch();
  const MotionParams params;
  WindowProblem problem;
  problem.knots.assign(s.knots.end() - 7, s.knots.end());
  problem.first_free = 3;
  problem.prior.resize(problem.knots.size(), {params.rotation_sigma, params.translation_sigma});
  for (int scan = mapped; scan < scan_count; ++scan) {
    for (const Point& p : thinned(s.scans[static_cast<std::size_t>(scan)]->points, params.keypoint_leaf)) {
      const SegmentTime at = locate(problem.knots, s.time(scan) + static_cast<double>(p.time));
      problem.keypoints.push_back({p.position().cast<double>(), Eigen::Vector3d::Zero(), at.segment, at.fraction, scan + 1 == scan_count});
    }
  }
  for (std::size_t i = 3; i < problem.knots.size(); ++i) problem.knots[i].pose.translation += Eigen::Vector3d(0.01, -0.01, 0.005);
  for (auto _ : state) {
    WindowProblem copy = problem;
    benchmark::DoNotOptimize(solve_window(s.map, copy, {}));
  }
  state.counters["points"] = static_cast<double>(problem.keypoints.size());
}

void deskew_step(benchmark::State& state) {
  int i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(stretch().deskewed(i++ % scan_count));
}

// Deskewing included; into a map that grows along the stretch.
void map_step(benchmark::State& state) {
  SurfaceMap map{SurfaceMapParams{}};
  int i = 0;
  for (auto _ : state) {
    if (i == scan_count) {
      state.PauseTiming();
      map = SurfaceMap{SurfaceMapParams{}};
      i = 0;
      state.ResumeTiming();
    }
    stretch().insert(map, i++);
  }
}

void whole(benchmark::State& state) {
  const Stretch& s = stretch();
  for (auto _ : state) {
    Odometry odometry({}, s.T_base_lidar);
    for (const CloudPtr& scan : s.scans) benchmark::DoNotOptimize(odometry.process(scan));
  }
  state.counters["a scan"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * scan_count, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

BENCHMARK(prefilter_step)->Unit(benchmark::kMillisecond);
BENCHMARK(thinning_step)->Unit(benchmark::kMillisecond);
BENCHMARK(rigid_alignment_step)->Unit(benchmark::kMillisecond);
BENCHMARK(window_step)->Unit(benchmark::kMillisecond);
BENCHMARK(deskew_step)->Unit(benchmark::kMillisecond);
BENCHMARK(map_step)->Unit(benchmark::kMillisecond);
BENCHMARK(whole)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sgraph
