#include "sgraph_slam/core/eval/plan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "sgraph_slam/core/eval/evaluation.hpp"

namespace sgraph {
namespace {

Plan plan_of(const std::string& text) {
  const std::string path = testing::TempDir() + "plan_test_truth.json";
  std::ofstream(path) << text;
  const Plan plan = read_plan(path);
  std::remove(path.c_str());
  return plan;
}

TEST(Plan, ReadsTheShortForm) {
  const Plan plan = plan_of(R"({"name": "short", "walls": [{"p": [0, 0], "q": [4, 3], "z": 0.5, "t": 0.15, "glass": false}],
    "rooms": [{"id": "A", "center": [1, 2], "width": [3, 4], "polygon": [[0, 0], [1, 1], [0, 2], [-1, 1]], "z": 0}], "corridors": []})");
  EXPECT_EQ(plan.name, "short");
  ASSERT_EQ(plan.walls.size(), 1u);
  EXPECT_DOUBLE_EQ(plan.walls[0].length(), 5);
  EXPECT_TRUE(std::isinf(plan.walls[0].height));
  ASSERT_EQ(plan.rooms.size(), 1u);
  EXPECT_NEAR(plan.rooms[0].yaw, M_PI_4, 1e-12);
  ASSERT_EQ(plan.levels.size(), 1u);
  EXPECT_DOUBLE_EQ(plan.levels[0].floor, 0.5);
  EXPECT_FALSE(plan.levels[0].ceiling_known);
}

TEST(Plan, ReadsTheLongForm) {
  const Plan plan = plan_of(R"({"walls": [{"p": [0, 0], "q": [4, 0], "z": 0, "t": 0.2, "height": 2.8, "extend_q": 0.1,
      "openings": [{"begin": 2, "end": 3, "bottom": 1, "top": 2, "pane": true}, {"begin": 0.5, "end": 1.4, "bottom": 0, "top": 2.1}]}],
    "columns": [{"center": [1, 2, 1.4], "size": [0.4, 0.4, 2.8], "round": true}], "furniture": [{"center": [1, 2, 0.4], "size": [1, 2, 0.8], "yaw": 0.1}],
    "storeys": [{"elevation": 1, "height": 2.8, "floor": true, "ceiling": true, "outline": [[0, 0], [1, 0], [1, 1]]},
                {"elevation": 4, "height": 2.8, "ceiling": false, "outline": [[0, 0], [1, 0], [1, 1]]}],
    "corridors": [{"id": 3, "center": [1, 2], "width": [30, 2], "yaw": 0.4}]})");
  ASSERT_EQ(plan.walls[0].openings.size(), 2u);
  EXPECT_DOUBLE_EQ(plan.walls[0].openings[0].begin, 0.5);  // in order
  EXPECT_TRUE(plan.walls[0].openings[1].pane);
  EXPECT_DOUBLE_EQ(plan.walls[0].extend_q, 0.1);
  ASSERT_EQ(plan.blocks.size(), 2u);
  EXPECT_TRUE(plan.blocks[0].round && !plan.blocks[0].furniture && plan.blocks[1].furniture);
  ASSERT_EQ(plan.levels.size(), 2u);
  EXPECT_DOUBLE_EQ(*plan.levels[0].ceiling, 3.8);
  EXPECT_FALSE(plan.levels[1].ceiling.has_value());
  EXPECT_TRUE(plan.levels[1].ceiling_known);
  EXPECT_EQ(plan.corridors[0].name, "3");
}

TEST(Plan, RefusesBrokenFiles) {
  EXPECT_THROW(read_plan("/nonexistent/truth.json"), std::runtime_error);
  for (const char* bad :
       {"", "{}", "[1]", R"({"walls": [{"p": [0, 0], "q": [0, 0], "t": 0.1}]})", R"({"walls": [{"p": [0, 0], "q": [1, 0], "t": -1}]})",
        R"({"walls": [{"p": [0], "q": [1, 0], "t": 0.1}]})", R"({"walls": [], "rooms": [{"id": "A", "center": [1, 2], "width": [1, 2]}]})"}) {
    EXPECT_THROW(plan_of(bad), std::runtime_error) << bad;
  }
}

TEST(Evaluation, ReportsWithoutNumbersThatAreNone) {
  Trajectory standing;
  for (int i = 0; i < 5; ++i) standing.push_back({Stamp::from_seconds(i), Pose{}});
  Evaluation evaluation;
  evaluation.final_poses = evaluate_trajectory(standing, standing);
  evaluation.map = MapError{};
  evaluation.rooms = PlaceScore{};
  evaluation.corridors = PlaceScore{};
  evaluation.walls = WallScore{};
  evaluation.remarks.push_back("remark");
  for (const std::string& text : {to_json(evaluation), to_table(evaluation)}) {
    EXPECT_EQ(text.find("nan"), std::string::npos) << text;
    EXPECT_EQ(text.find("null"), std::string::npos) << text;
    EXPECT_NE(text.find("remark"), std::string::npos);
  }
  EXPECT_THROW(evaluate_trajectory(standing, {{Stamp::from_seconds(100), Pose{}}}), std::runtime_error);
}

}  // namespace
}  // namespace sgraph
