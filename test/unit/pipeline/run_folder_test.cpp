#include "sgraph_slam/core/pipeline/run_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/io/graph_json.hpp"
#include "sgraph_slam/core/io/tum.hpp"
#include "sgraph_slam/core/params/params_io.hpp"
#include "sgraph_slam/core/pipeline/pipeline.hpp"

namespace sgraph {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr int scans = 40;

// What a LiDAR of 16 rings sees at (x, 0, 1) in an empty hall of 12 x 8 x 3 m, walls at x = -3, 9 and y = -3, 5.
Cloud scan_at(int number) {
  const Eigen::Vector3d origin(0.1 * number, 0, 1);
  Cloud cloud;
  cloud.stamp = {1'700'000'000'000'000'000 + number * 100'000'000LL};
  for (int ring = 0; ring < 16; ++ring) {
    const double elevation = (2 * ring - 15) * M_PI / 180;
    for (int a = 0; a < 900; ++a) {
      const double azimuth = (a + 0.2) * 2 * M_PI / 900;
      const Eigen::Vector3d d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
      double t = d.z() > 0 ? (3 - origin.z()) / d.z() : -origin.z() / d.z();
      t = std::min(t, ((d.x() > 0 ? 9 : -3) - origin.x()) / d.x());
      t = std::min(t, ((d.y() > 0 ? 5 : -3) - origin.y()) / d.y());
      Point point;
      point.x = static_cast<float>(t * d.x());
      point.y = static_cast<float>(t * d.y());
      point.z = static_cast<float>(t * d.z());
      point.ring = static_cast<std::uint16_t>(ring);
      cloud.points.push_back(point);
    }
  }
  return cloud;
}

class RunFolderTest : public testing::Test {
 protected:
  RunFolderTest() : folder_(fs::temp_directory_path() / ("run_folder_test." + std::to_string(getpid()))) { fs::create_directories(folder_); }
  ~RunFolderTest() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static Pose mount() { return {Eigen::Quaterniond::Identity(), {0, 0, 0.4}}; }
  static std::unique_ptr<Pipeline> walked(Stage until) {
    auto pipeline = std::make_unique<Pipeline>(Params(), mount(), until);
    for (int i = 0; i < scans; ++i) pipeline->process(scan_at(i));
    pipeline->process(scan_at(5));  // a repeated message
    pipeline->finish();
    return pipeline;
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }
  fs::path folder_;
};

TEST_F(RunFolderTest, HoldsEverythingAndAgreesWithItself) {
  const auto pipeline = walked(Stage::mapping);
  RunInfo info;
  info.sources = {"hall.bag"};
  info.wall_seconds = 2;
  info.dropped_before = {{"layout", 3}};
  write_run(folder_.string(), pipeline->run(), Params(), info);
  EXPECT_THAT(files(), ElementsAre("decisions.csv", "floor_plan.dxf", "floor_plan.png", "floor_plan.svg", "graph.json", "keyframes.tum", "map.pcd",
                                   "map.pgm", "map.yaml", "params.yaml", "report.json", "timings.csv", "trajectory.tum", "trajectory_live.tum"));

  // Every scan that was accepted is in both trajectories, under its own stamp; the walk is 3.9 m straight ahead.
  const Trajectory trajectory = read_tum(path("trajectory.tum"));
  ASSERT_EQ(trajectory.size(), static_cast<std::size_t>(scans));
  EXPECT_EQ(read_tum(path("trajectory_live.tum")).size(), static_cast<std::size_t>(scans));
  for (int i = 0; i < scans; ++i) EXPECT_EQ(trajectory[static_cast<std::size_t>(i)].stamp, scan_at(i).stamp);
  const Pose T_first_last = trajectory.front().pose.inverse() * trajectory.back().pose;
  EXPECT_LT((T_first_last.translation - Eigen::Vector3d(3.9, 0, 0)).norm(), 0.03);

  const GraphSnapshot graph = parse_graph_json(read_file(path("graph.json")));
  EXPECT_EQ(read_tum(path("keyframes.tum")).size(), graph.keyframes.size());
  EXPECT_GE(graph.keyframes.size(), 5U);
  EXPECT_GE(graph.planes.size(), 5U);  // four walls and a floor

  const auto report = nlohmann::json::parse(read_file(path("report.json")));
  EXPECT_EQ(report.at("counts").at("scans"), scans + 1);
  EXPECT_EQ(report.at("counts").at("accepted"), scans);
  EXPECT_EQ(report.at("counts").at("keyframes"), graph.keyframes.size());
  EXPECT_EQ(report.at("counts").at("planes"), graph.planes.size());
  EXPECT_EQ(report.at("dropped"), (nlohmann::json{{"layout", 3}, {to_string(ScanVerdict::not_later), 1}}));
  EXPECT_NEAR(report.at("path_length_m").get<double>(), 3.9, 0.1);
  EXPECT_EQ(report.at("stages_ms").at("odometry").at("runs"), scans + 1);
  EXPECT_GT(report.at("stages_ms").at("odometry").at("p99").get<double>(), report.at("stages_ms").at("odometry").at("p50").get<double>());
  EXPECT_FALSE(report.at("solves").empty());
  EXPECT_GT(report.at("peak_memory_mib").get<double>(), 5);
  EXPECT_GT(report.at("cpu_seconds").get<double>(), 0.01);
}

TEST_F(RunFolderTest, TimingsHaveARowAScan) {
  const auto pipeline = walked(Stage::mapping);
  std::istringstream lines(timings_csv(pipeline->run().records()));
  std::string line;
  std::getline(lines, line);
  EXPECT_THAT(line, testing::StartsWith("stamp,prefilter_ms,odometry_ms,segmentation_ms,mapping_ms,"));
  const auto commas = std::count(line.begin(), line.end(), ',');
  int rows = 0;
  std::string last;
  while (std::getline(lines, line)) {
    last = line;
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), commas);
    ++rows;
  }
  EXPECT_EQ(rows, scans + 1);
  EXPECT_THAT(last, HasSubstr(to_string(ScanVerdict::not_later)));
}

TEST_F(RunFolderTest, TheParametersInForceReadBack) {
  Params params;
  params.prefilter.leaf = 0.123;
  write_run(folder_.string(), Pipeline(params, mount(), Stage::prefilter).run(), params, RunInfo());
  Params copy;
  apply_values(read_yaml_values(path("params.yaml")), [&copy](ParamVisitor& v) { copy.describe(v); });
  EXPECT_EQ(copy.prefilter.leaf, 0.123);
}

TEST_F(RunFolderTest, AShorterRunWritesWhatItKnows) {
  write_run(folder_.string(), walked(Stage::odometry)->run(), Params(), RunInfo());
  EXPECT_THAT(files(), ElementsAre("keyframes.tum", "params.yaml", "report.json", "timings.csv", "trajectory.tum", "trajectory_live.tum"));
  EXPECT_EQ(read_tum(path("trajectory.tum")).size(), static_cast<std::size_t>(scans));
  const auto report = nlohmann::json::parse(read_file(path("report.json")));
  EXPECT_TRUE(report.at("stages_ms").contains("odometry"));
  EXPECT_FALSE(report.at("stages_ms").contains("segmentation"));
}

// Two runs over the same data are the same to the last bit.
TEST_F(RunFolderTest, RunsAreReproducible) {
  const auto a = walked(Stage::mapping);
  const auto b = walked(Stage::mapping);
  EXPECT_EQ(graph_json(*a->run().snapshot()), graph_json(*b->run().snapshot()));
}

TEST_F(RunFolderTest, ARecordingWithoutAUsefulScanIsNoTrouble) {
  Pipeline pipeline(Params(), mount());
  for (int i = 0; i < 3; ++i) {
    Cloud cloud;
    cloud.stamp = {1 + i};
    cloud.points.resize(10);
    for (Point& point : cloud.points) point.x = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(pipeline.process(cloud).verdict, ScanVerdict::too_few_points);
  }
  pipeline.finish();
  const RunReport report = write_run(folder_.string(), pipeline.run(), Params(), RunInfo());
  EXPECT_EQ(report.accepted, 0);
  EXPECT_EQ(report.dropped.at(to_string(ScanVerdict::too_few_points)), 3);
  EXPECT_TRUE(read_tum(path("trajectory.tum")).empty());
}

}  // namespace
}  // namespace sgraph
