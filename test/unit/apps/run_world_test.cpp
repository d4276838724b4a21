// The programs from outside: what they write, and what they say when they can't.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/io/tum.hpp"

namespace sgraph {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* world = R"(name: two_rooms
height: 2.7
walls:
  - [[0, 0], [9, 0], [9, 5], [0, 5], [0, 0]]
  - [[5, 0], [5, 5]]
doors:
  - {at: [5, 2.5], width: 1.2}
rooms: {west: [2, 2.5], east: [7, 2.5]}
route: {waypoints: [[1.5, 2.5], [7.5, 2.5]], stand: 1}
)";

class RunWorldTest : public testing::Test {
 protected:
  RunWorldTest() : folder_(fs::temp_directory_path() / ("run_world_test." + std::to_string(getpid()))) {
    fs::create_directories(folder_);
    write_file(at("world.yaml"), world);
  }
  ~RunWorldTest() override { fs::remove_all(folder_); }

  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  // Exit status of a program that lies beside this one; what it said is in `said_`.
  int run(const std::string& command) {
    const fs::path programs = fs::canonical("/proc/self/exe").parent_path();
    const int status = std::system(((programs / command).string() + " > " + at("said") + " 2>&1").c_str());
    said_ = read_file(at("said"));
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  int run_world(const std::string& options) { return run("run_world " + at("world.yaml") + " --duration 3 " + options); }

  fs::path folder_;
  std::string said_;
};

TEST_F(RunWorldTest, AVariantGivesTheRunFolderThatItGivesAlone) {
  ASSERT_EQ(run_world("--out " + at("both") + " --variant full --variant robot:odometry.source=topic,mapping.topological_layer=false"), 0) << said_;
  EXPECT_THAT(said_, HasSubstr("robot: 30 scans"));
  ASSERT_EQ(run_world("--quiet --out " + at("full")), 0) << said_;
  ASSERT_EQ(run_world("--quiet --out " + at("robot") + " --odometry topic --set mapping.topological_layer=false"), 0) << said_;
  for (const std::string name : {"full", "robot"}) {
    for (const std::string file : {"/graph.json", "/trajectory.tum", "/trajectory_live.tum", "/map.pcd", "/params.yaml"}) {
      EXPECT_EQ(read_file(at("both/" + name + file)), read_file(at(name + file))) << name << file;
    }
    EXPECT_EQ(read_file(at("both/ground_truth.tum")), read_file(at(name + "/ground_truth.tum")));
    EXPECT_EQ(read_tum(at("both/" + name + "/trajectory.tum")).size(), 30U);
  }
  EXPECT_NE(read_file(at("full/trajectory.tum")), read_file(at("robot/trajectory.tum")));
}

TEST_F(RunWorldTest, EvaluateMeasuresAVariant) {
  ASSERT_EQ(run_world("--quiet --out " + at("runs") + " --variant full --variant odometry:until=odometry"), 0) << said_;
  for (const std::string name : {"full", "odometry"}) {
    ASSERT_EQ(run("evaluate " + at("runs/" + name) + " --no-picture --truth " + at("runs")), 0) << said_;
    const auto evaluation = nlohmann::json::parse(read_file(at("runs/" + name + "/evaluation.json")));
    EXPECT_LT(evaluation.at("trajectory").at("ate_translation_m").at("rmse").get<double>(), 0.02);
    EXPECT_EQ(evaluation.contains("map"), name == "full");
    const auto report = nlohmann::json::parse(read_file(at("runs/" + name + "/report.json")));
    EXPECT_GT(report.at("stages_cpu_ms").at("odometry").at("mean").get<double>(), 0);
    EXPECT_EQ(report.at("mapping_steps_cpu_ms").contains("association"), name == "full");
    EXPECT_GT(report.at("cpu_seconds").get<double>(), 1e-3 * 30 * report.at("stages_cpu_ms").at("odometry").at("mean").get<double>());
  }
}

TEST_F(RunWorldTest, WhatIsWrongIsSaidInALine) {
  EXPECT_EQ(run_world("--out " + at("runs") + " --variant bad:prefilter.leav=1"), 1);
  EXPECT_THAT(said_, HasSubstr("variant bad: "));
  EXPECT_THAT(said_, HasSubstr("prefilter.leaf"));
  EXPECT_FALSE(fs::exists(at("runs")));
  EXPECT_EQ(run_world("--out " + at("runs") + " --variant twice --variant twice"), 1);
  EXPECT_THAT(said_, HasSubstr("two variants are named twice"));
  EXPECT_EQ(run("run_world " + at("nowhere.yaml") + " --out " + at("runs")), 1);
  EXPECT_THAT(said_, HasSubstr("nowhere.yaml"));
}

}  // namespace
}  // namespace sgraph
