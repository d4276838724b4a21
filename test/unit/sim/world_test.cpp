#include "sgraph_slam/core/sim/world.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>

namespace sgraph::sim {
namespace {

const char* const base = R"(
walls:
  - {path: [[0, 0], [10, 0], [10, 6], [0, 6], [0, 0]], thickness: 0.3}
  - [[5, 0], [5, 6]]
doors: [[5, 3]]
rooms: {left: [2, 3], right: [8, 3]}
)";

std::string with(const std::string& more, const std::string& route = "route: {waypoints: [[2, 3], [8, 3]]}\n") { return base + more + route; }

// What parse_world says of a wrong world; empty when it takes it.
std::string error_of(const std::string& text) {
  try {
    parse_world(text, "w.yaml");
    return {};
  } catch (const WorldError& error) {
    return error.what();
  }
}

void expect_error(const std::string& text, const std::string& place, const std::string& part) {
  const std::string error = error_of(text);
  EXPECT_EQ(error.rfind(place, 0), 0U) << error;
  EXPECT_NE(error.find(part), std::string::npos) << error;
}

TEST(World, RoomsLieBetweenTheFacesOfTheirWalls) {
  const World world = parse_world(with(""));
  const Storey& storey = world.storeys.front();
  ASSERT_EQ(storey.rooms.size(), 2U);
  // Outer walls 0.3 thick about 0, 10, 6; the inner one 0.15 about 5.
  EXPECT_EQ(storey.rooms[0].name, "left");
  EXPECT_NEAR(storey.rooms[0].width.x(), 5 - 0.15 - 0.075, 1e-9);
  EXPECT_NEAR(storey.rooms[0].width.y(), 6 - 0.3, 1e-9);
  EXPECT_NEAR(storey.rooms[0].center.x(), (0.15 + 4.925) / 2, 1e-9);
  EXPECT_NEAR(storey.rooms[0].center.y(), 3, 1e-9);
  EXPECT_EQ(storey.walls.size(), 5U);
  EXPECT_EQ(storey.walls[4].openings.size(), 1U);
}

TEST(World, AWingIsTheSamePlanTurned) {
  const World world = parse_world(R"(
walls: [[[-30, -30], [-20, -30]]]
outline: [[-40, -40], [40, -40], [40, 40], [-40, 40]]
wings:
  - name: w
    at: [1, 2]
    yaw_deg: 60
    walls: [[[0, 0], [8, 0], [8, 5], [0, 5], [0, 0]]]
    rooms: {r: [4, 2]}
    columns: [{at: [6, 1], size: 0.4}]
route: {waypoints: [{at: [2, 2.5], wing: w}, {at: [6, 2.5], wing: w}]}
)");
  const Storey& storey = world.storeys.front();
  const Eigen::Vector2d expected = Eigen::Vector2d(1, 2) + Eigen::Rotation2Dd(M_PI / 3) * Eigen::Vector2d(4, 2.5);
  ASSERT_EQ(storey.rooms.size(), 1U);
  EXPECT_LT((storey.rooms[0].center - expected).norm(), 1e-9);
  EXPECT_NEAR(storey.rooms[0].width.x(), 7.85, 1e-9);
  EXPECT_NEAR(storey.rooms[0].width.y(), 4.85, 1e-9);
  EXPECT_NEAR(storey.rooms[0].yaw, M_PI / 3, 1e-9);
  EXPECT_NEAR(storey.columns[0].yaw, M_PI / 3, 1e-9);
  EXPECT_LT((world.route.waypoints[1].position - (Eigen::Vector2d(1, 2) + Eigen::Rotation2Dd(M_PI / 3) * Eigen::Vector2d(6, 2.5))).norm(), 1e-9);
}

TEST(World, RoundsAreWrittenOut) {
  const World world = parse_world(with("", "route: {rounds: 3, waypoints: [[2, 3], [8, 3]]}\n"), "w.yaml");
  EXPECT_EQ(world.route.waypoints.size(), 7U);
  EXPECT_EQ(world.route.waypoints.back().position, world.route.waypoints.front().position);
}

TEST(World, SchemaErrorsNameTheLine) {
  EXPECT_EQ(error_of(with("")), "");
  expect_error("", "w.yaml", "map");
  expect_error("walls: [[0, 0\n", "w.yaml:", "not YAML");
  expect_error(with("wals: []\n"), "w.yaml:7:", "`wals`");
  expect_error(with("height: tall\n"), "w.yaml:7:", "`height` must be a number");
  expect_error(with("height: .nan\n"), "w.yaml:7:", "`height` must be a number");
  expect_error(with("height: -1\n"), "w.yaml:7:", "between 1 and 50");
  expect_error(with("ceiling: maybe\n"), "w.yaml:7:", "true or false");
  expect_error(with("columns:\n  - {at: [2, 1]}\n"), "w.yaml:8:", "needs `size`");
  expect_error(with("columns:\n  - {at: [2, 1, 0], size: 0.4}\n"), "w.yaml:8:", "2 numbers");
  expect_error(with("furniture:\n  - {kind: throne, at: [2, 1]}\n"), "w.yaml:8:", "`throne`");
  expect_error(with("furniture:\n  - {kind: table, at: [2, 1], colour: red}\n"), "w.yaml:8:", "`colour`");
  expect_error(with("windows: [[2, 1]]\n"), "w.yaml:7:", "no wall passes at (2, 1)");
  expect_error(with("windows: [[5, 3.2]]\n"), "w.yaml:7:", "overlap");
  expect_error(with("windows: [[0.3, 0]]\n"), "w.yaml:7:", "beyond the end");
  expect_error(with("windows: [[5, 0]]\n"), "w.yaml:7:", "two walls meet");
  expect_error(with("motion: {profile: rocket}\n"), "w.yaml:7:", "legged or walker");
  expect_error(with("", "route: {waypoints: []}\n"), "w.yaml:7:", "empty");
  expect_error(with("", "route: {waypoints: [[2, 3], [2, 3]]}\n"), "w.yaml:7:", "same place");
  expect_error(with("", "route: {waypoints: [[2, 3]], rounds: 1.5}\n"), "w.yaml:7:", "whole number");
  expect_error(with("", "route: {waypoints: [{at: [2, 3], wing: west}]}\n"), "w.yaml:7:", "no wing is called `west`");
  expect_error(with("", ""), "w.yaml", "needs `route`");
  expect_error("walls: []\nroute: {waypoints: [[0, 0]]}\n", "w.yaml:1:", "empty");
  expect_error(with("corridors: {c: [20, 20]}\n"), "w.yaml:7:", "no wall bounds it");
  expect_error(with("corridors: {c: {at: [2, 3], yaw_deg: 20}}\n"), "w.yaml:7:", "right angle");
  expect_error(with("", "route: {duration: 3, waypoints: [[2, 3], [8, 3]]}\n"), "w.yaml", "no speed");
  expect_error(with("extends: nothing.yaml\n"), "w.yaml:7:", "nothing.yaml");
}

TEST(World, ARouteThroughSomethingIsRefusedWithThePlace) {
  const auto route = [](const std::string& points) { return "route: {return: false, waypoints: " + points + "}\n"; };
  expect_error(with("", route("[[2, 3], [2, 5], [8, 5]]")), "w.yaml:7:", "a wall (line 4) at (4.6");
  expect_error(with("", route("[[2, 3], [12, 3]]")), "w.yaml:7:", "a wall (line 3) at (9.6");
  expect_error(with("columns: [{at: [3.5, 3], size: 0.4}]\n", route("[[2, 3], [8, 3]]")), "w.yaml:8:", "a column (line 7) at (3.");
  expect_error(with("furniture: [{kind: table, at: [7, 3.4]}]\n", route("[[2, 3], [8, 3]]")), "w.yaml:8:", "a table (line 7) at (5.9");
  expect_error(with("glass: [{at: [5, 5], width: 1}]\n", route("[[2, 5], [8, 5]]")), "w.yaml:8:", "a wall");
  expect_error(with("", route("[[20, 3], [22, 3]]")), "w.yaml:7:", "outline");
  expect_error(with("people: [{path: [[7, 3]], speed: 0}]\n", route("[[2, 3], [8, 3]]")), "w.yaml:8:", "person 1");
  // Beside the table, under a lamp that hangs high, and past somebody who stands aside, it is free.
  EXPECT_EQ(error_of(with("furniture: [{kind: table, at: [7, 4.2]}]\n", route("[[2, 3], [8, 3]]"))), "");
  EXPECT_EQ(error_of(with("furniture: [{kind: box, at: [7, 3], z: 2.2, size: [0.5, 0.5, 0.3]}]\n", route("[[2, 3], [8, 3]]"))), "");
  EXPECT_EQ(error_of(with("people: [{path: [[7, 4]], speed: 0}]\n", route("[[2, 3], [8, 3]]"))), "");
}

TEST(World, OthersInTheWayAreRefused) {
  expect_error(with("people: [{path: [[2, 1], [8, 1]]}]\n"), "w.yaml:7:", "a person walks through a wall");
  expect_error(with("furniture: [{kind: wardrobe, at: [4.7, 1], yaw_deg: 90}]\n"), "w.yaml:7:", "a wardrobe sticks in a wall");
}

TEST(World, ExtendsReplacesWholeKeysAndReportsTheBasesErrorsThere) {
  const std::string directory = ::testing::TempDir();
  const auto write = [&](const std::string& name, const std::string& text) { std::ofstream(directory + "/" + name) << text; };
  write("sim_base.yaml", "name: base\n" + with(""));
  const World world = parse_world("extends: sim_base.yaml\nname: turned\nstart_heading_deg: 37\n", "w.yaml", directory);
  EXPECT_EQ(world.name, "turned");
  EXPECT_NEAR(world.route.start_heading, 37 * M_PI / 180, 1e-12);
  EXPECT_EQ(world.storeys.front().rooms.size(), 2U);

  write("sim_base.yaml", "name: base\nheight: 100\n" + with(""));
  try {
    parse_world("extends: sim_base.yaml\n", "w.yaml", directory);
    FAIL() << "a wrong base was taken";
  } catch (const WorldError& error) {
    EXPECT_NE(std::string(error.what()).find("sim_base.yaml:2:"), std::string::npos) << error.what();
  }
  write("sim_base.yaml", "extends: sim_base.yaml\n");
  EXPECT_THROW(parse_world("extends: sim_base.yaml\n", "w.yaml", directory), WorldError);
  std::remove((directory + "/sim_base.yaml").c_str());
}

}  // namespace
}  // namespace sgraph::sim
