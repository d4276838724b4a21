#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sgraph_slam/core/sim/simulator.hpp"

namespace sgraph::sim {
namespace {

// An L-shaped room and two rooms joined by a wide opening, on a corridor; a closed block stands in the L.
constexpr const char* plan = R"(
name: plan
wall_thickness: 0.2
walls:
  - [[0, 0], [12, 0], [12, 2], [0, 2], [0, 0]]
  - [[0, 2], [0, 10], [4, 10], [4, 6], [8, 6], [8, 2]]
  - [[8, 6], [12, 6], [12, 2]]
  - [[10, 2], [10, 6]]
  - [[1, 6.5], [3, 6.5], [3, 8.5], [1, 8.5], [1, 6.5]]
doors: [[2, 2], [9, 2]]
openings: [{at: [10, 4], width: 2.4, joins: true}]
places: {way: {at: [6, 1], kind: corridor}, L: [2, 4], pair: {at: [9, 4], kind: hall}}
furniture: [{kind: box, at: [6.5, 4.5]}]
route: {waypoints: [[1, 1], [2, 1], [2, 4], [2, 1]]}
)";

nlohmann::json truth_of(const World& world) {
  const Motion motion = motion_along_route(world);
  return nlohmann::json::parse(truth_json(world, motion, motion.duration()));
}

const nlohmann::json& named(const nlohmann::json& list, const std::string& id) {
  const auto found = std::find_if(list.begin(), list.end(), [&](const nlohmann::json& j) { return j.at("id") == id; });
  EXPECT_NE(found, list.end()) << id;
  return *found;
}

TEST(PlacesOfAWorld, AreThePiecesOfFloorBetweenItsWalls) {
  const nlohmann::json truth = truth_of(parse_world(plan));
  ASSERT_EQ(truth.at("places").size(), 4U);  // the block is the fourth
  EXPECT_NEAR(named(truth.at("places"), "way").at("area").get<double>(), 11.8 * 1.8, 0.01);
  const nlohmann::json& l = named(truth.at("places"), "L");
  EXPECT_EQ(l.at("polygon").size(), 6U);
  ASSERT_EQ(l.at("holes").size(), 1U);
  EXPECT_NEAR(l.at("area").get<double>(), 7.8 * 3.8 + 3.8 * 4 - 2.2 * 2.2, 0.02);
  const nlohmann::json& pair = named(truth.at("places"), "pair");
  EXPECT_EQ(pair.at("kind"), "hall");
  EXPECT_NEAR(pair.at("area").get<double>(), 1.8 * 3.8 * 2 + 0.2 * 2.4, 0.02);
  EXPECT_TRUE(l.at("entered").get<bool>());
  EXPECT_FALSE(pair.at("entered").get<bool>());
}

TEST(PlacesOfAWorld, DoorsLeadFromOneToAnother) {
  const nlohmann::json truth = truth_of(parse_world(plan));
  ASSERT_EQ(truth.at("doors").size(), 2U);
  const nlohmann::json& door = truth.at("doors").at(1);  // in the order along the wall, which runs westwards there
  EXPECT_NEAR(door.at("position").at(0).get<double>(), 2, 1e-9);
  EXPECT_NEAR(door.at("position").at(1).get<double>(), 2, 1e-9);
  EXPECT_NEAR(door.at("width").get<double>(), 0.95, 1e-9);
  EXPECT_TRUE((door.at("from") == "L" && door.at("to") == "way") || (door.at("from") == "way" && door.at("to") == "L"));
}

TEST(PlacesOfAWorld, ASeedWithoutWallsAroundItIsRefused) {
  std::string open = plan;
  open.replace(open.find("L: [2, 4]"), 9, "L: [20, 4]");
  EXPECT_THROW(parse_world(open), WorldError);
}

TEST(ASession, IsTheSameForItsSeedAndKeepsTheBuilding) {
  const World world = parse_world(plan);
  const World a = with_session(world, 3);
  const World b = with_session(world, 3);
  ASSERT_EQ(a.route.waypoints.size(), b.route.waypoints.size());
  EXPECT_EQ(a.route.start_heading, b.route.start_heading);
  EXPECT_GT((a.route.waypoints.front().position - world.route.waypoints.front().position).norm(), 0.1);
  ASSERT_EQ(a.storeys[0].walls.size(), world.storeys[0].walls.size());
  bool moved = false;
  for (std::uint64_t seed = 1; seed < 12; ++seed) {
    const World other = with_session(world, seed);
    moved = moved || !other.session.moved.empty();
    for (const FurnitureMove& m : other.session.moved) EXPECT_NEAR((m.to - m.from).norm(), 0.65, 0.36);
  }
  EXPECT_TRUE(moved);
}

// Behind a shut door the robot doesn't go, and its leaf stands in the opening.
TEST(ASession, ShutsDoorsThatTheRouteThenAvoids) {
  const World world = parse_world(plan);
  for (std::uint64_t seed = 1; seed < 30; ++seed) {
    const World other = with_session(world, seed);
    if (other.session.closed_doors.empty()) continue;
    const nlohmann::json truth = truth_of(other);
    int shut = 0;
    for (const nlohmann::json& door : truth.at("doors")) {
      if (!door.at("closed").get<bool>()) continue;
      ++shut;
      EXPECT_FALSE(door.at("wanted").get<bool>());
    }
    EXPECT_EQ(shut, static_cast<int>(other.session.closed_doors.size()));
    return;
  }
  FAIL() << "no seed shuts a door";
}

}  // namespace
}  // namespace sgraph::sim
