#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>

#include "sgraph_slam/core/eval/map_error.hpp"
#include "sgraph_slam/core/eval/plan.hpp"
#include "sgraph_slam/core/sim/simulator.hpp"

namespace sgraph {
namespace {

// The simulator's surfaces and the plan read back from its truth are two descriptions of one building: points placed with the true motion lie on the
// plan to within the range noise.
TEST(MapError, ASimulatedMapWithTheTrueMotionHasTheRangeNoiseAsItsError) {
  sim::World world = sim::read_world("worlds/se1.yaml");
  sim::SimulationSettings settings;
  settings.lidar.range_noise = 0.02;
  const sim::SimulatedSource source(world, settings);
  const std::string path = testing::TempDir() + "simulated_truth.json";
  std::ofstream(path) << sim::truth_json(source.world(), source.motion(), source.duration());
  const Plan plan = read_plan(path);
  std::remove(path.c_str());

  std::vector<Eigen::Vector3f> points;
  for (int scan = 50; scan < source.scan_count(); scan += 400) {
    const double time = source.lidar().time_of(scan);
    for (const Point& p : source.lidar().scan(scan).points) {
      const Pose T_world_base = source.motion().pose_at(time + static_cast<double>(p.time));
      points.push_back((T_world_base * (source.T_base_lidar() * p.position().cast<double>().eval())).cast<float>());
    }
  }
  ASSERT_GT(points.size(), 100'000u);
  const MapError error = map_error(points, Pose{}, plan, 0.5);
  EXPECT_GT(error.structure.count, error.points / 2);
  EXPECT_LT(error.structure.rmse, 0.018);
  EXPECT_GT(error.structure.rmse, 0.010);
  EXPECT_LT(error.structure.median, 0.013);
  EXPECT_GT(error.furniture.count, 1000);
  EXPECT_LT(error.furniture.rmse, 0.018);
  EXPECT_LT(error.beyond_cap, error.points / 100);  // views through windows
  EXPECT_EQ(error.unknown_height, 0);
}

}  // namespace
}  // namespace sgraph
