#include "sgraph_slam/core/places/topological_layer.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/plan.hpp"

namespace sgraph {
namespace {

class Layer : public testing::Test {
 protected:
  std::vector<PlanePair> visit(const Eigen::Vector2d& position) { return layer.visit(graph, plan.walls, {{now++}, position, 0}, log); }
  void judge() { layer.judge(graph, plan.walls, nullptr, {now++}, log); }

  // The walls as planes of the graph, as the back end has them.
  void add_planes() {
    Transaction edit;
    while (!graph.find(PlaneId{static_cast<std::int64_t>(plan.walls.size()) - 1})) {
      const Wall& wall = plan.walls[static_cast<std::size_t>(graph.planes().size() + edit.planes.size())];
      edit.planes[graph.new_plane_id()] = {{wall.normal.x(), wall.normal.y(), 0}, wall.offset};
      if (graph.planes().size() + edit.planes.size() == plan.walls.size()) break;
    }
    ASSERT_TRUE(graph.apply(edit).ok());
  }

  PlaceLayerParams params;
  TopologicalLayer layer{params};
  Graph graph;
  Plan plan;
  DecisionLog log;
  std::int64_t now = 0;
};

TEST_F(Layer, FindsARoomOnceAndKnowsItAgain) {
  plan.box(0, 0, 6, 4);
  visit({1, 1});
  visit({5, 3});
  EXPECT_EQ(layer.rooms().size(), 1U);
  EXPECT_EQ(log.size(), 1U);
  EXPECT_TRUE(log[0].accepted);
}

TEST_F(Layer, ARoomsWallsMakeNoCorridor) {
  plan.box(0, 0, 7, 3);
  visit({1, 1});
  visit({3, 1});
  EXPECT_EQ(layer.rooms().size(), 1U);
  EXPECT_TRUE(layer.corridors().empty());
}

TEST_F(Layer, ACorridorIsUpgradedWhenItsEndWallsAppear) {
  plan.add({0, 0}, {6, 0});
  plan.add({6, 2.5}, {0, 2.5});
  visit({3, 1});
  ASSERT_EQ(layer.corridors().size(), 1U);
  const CorridorId corridor = layer.corridors().begin()->first;
  plan.add({0, 2.5}, {0, 0});
  plan.add({6, 0}, {6, 2.5});
  visit({3, 1});
  EXPECT_TRUE(layer.corridors().empty());
  ASSERT_EQ(layer.rooms().size(), 1U);
  EXPECT_EQ(layer.rooms().begin()->second.history.was, corridor);
  EXPECT_NE(log.back().reason.find("upgraded from corridor/0"), std::string::npos);
}

TEST_F(Layer, ARoomWhoseWallsDoNotHoldUpIsWithdrawnAfterSomeJudgements) {
  plan.box(0, 0, 6, 4);
  visit({1, 1});
  plan.add({3, 0}, {3, 4});  // a wall through the middle
  plan.add({2.8, 4}, {2.8, 0});
  for (int i = 0; i + 1 < params.topology.withdraw_after; ++i) judge();
  EXPECT_EQ(layer.rooms().size(), 1U);
  judge();
  EXPECT_TRUE(layer.rooms().empty());
  EXPECT_FALSE(log.back().accepted);
  EXPECT_NE(log.back().reason.find("runs through the inside"), std::string::npos);
}

TEST_F(Layer, OneGoodJudgementForgives) {
  plan.box(0, 0, 6, 4);
  visit({1, 1});
  const std::vector<Wall> whole = plan.walls;
  for (int round = 0; round < 4; ++round) {
    plan.walls[2].support = {{0, 0.5}};
    judge();
    plan.walls = whole;
    judge();
  }
  EXPECT_EQ(layer.rooms().size(), 1U);
}

// Entered again with 25 cm of drift: new planes beside the old ones. The room is the same, so its walls are too.
TEST_F(Layer, ARoomSeenAgainWithDriftShowsWhichPlanesAreOneWall) {
  const auto first = plan.box(0, 0, 6, 4);
  visit({1, 1});
  now += params.topology.recent + 5;
  const auto second = plan.box(0.25, -0.15, 6.25, 3.85);
  for (const PlaneId id : second) plan.walls[static_cast<std::size_t>(id.value)].last_seen = {now};
  const std::vector<PlanePair> same = visit({1.2, 1});
  ASSERT_EQ(same.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(same[i], PlanePair(first[i], second[i]));
  EXPECT_EQ(layer.rooms().size(), 1U);
}

// Seen first: the front of a row of shelves 5 cm before the wall. As the wall itself gets known, it takes its place, and the width is the wall's.
TEST_F(Layer, TheWallTakesThePlaceOfWhatStandsBeforeIt) {
  const auto box = plan.box(0, 0, 6, 4);
  const PlaneId shelves = plan.add({6 - 0.05, 0.5}, {6 - 0.05, 3.5});
  for (Wall& wall : plan.walls) wall.views = wall.id == box[1] ? 1 : 10;
  visit({1, 1});
  ASSERT_EQ(layer.rooms().size(), 1U);
  EXPECT_EQ(layer.rooms().begin()->second.shape.walls[1], shelves);
  plan.walls[static_cast<std::size_t>(box[1].value)].views = 30;
  judge();
  EXPECT_EQ(layer.rooms().begin()->second.shape.walls[1], box[1]);
  EXPECT_NEAR(layer.rooms().begin()->second.shape.area.size.x(), 6, 1e-9);
  EXPECT_NE(log.back().reason.find("shows more of a side"), std::string::npos);
  plan.walls[static_cast<std::size_t>(shelves.value)].views = 30;
  judge();
  EXPECT_EQ(layer.rooms().begin()->second.shape.walls[1], box[1]) << "no to and fro";
}

// A cabinet's side, 1.2 m high, over two thirds of the width: the corridor goes on behind it.
TEST_F(Layer, ACabinetDoesNotDivideACorridor) {
  plan.add({0, 0}, {30, 0});
  plan.add({30, 2}, {0, 2});
  for (Wall& wall : plan.walls) wall.height = 2.5;
  plan.walls[static_cast<std::size_t>(plan.add({14, 1.4}, {14, 0}).value)].height = 1.2;
  plan.walls[static_cast<std::size_t>(plan.add({15, 0}, {15, 1.4}).value)].height = 1.2;
  for (double x = 1; x < 30; x += 1) visit({x, 1});
  judge();
  ASSERT_EQ(layer.corridors().size(), 1U);
  EXPECT_NEAR(layer.corridors().begin()->second.shape.area.size.x(), 30, 1e-9);
}

// Two cabinets in a corridor face each other over most of its width, with the corridor's walls beside them. It's no room: they're low; and were they
// high, the corridor would still be more than this piece of it.
TEST_F(Layer, WhatStandsInACorridorMakesNoRoomOfIt) {
  for (const double height : {1.2, 2.5}) {
    plan = {};
    layer = TopologicalLayer(params);
    plan.add({0, 0}, {30, 0});
    plan.add({30, 2.3}, {0, 2.3});
    for (Wall& wall : plan.walls) wall.height = 2.5;
    visit({5, 1});
    ASSERT_EQ(layer.corridors().size(), 1U);
    plan.walls[static_cast<std::size_t>(plan.add({14, 1.7}, {14, 0}).value)].height = height;
    plan.walls[static_cast<std::size_t>(plan.add({17, 0}, {17, 1.7}).value)].height = height;
    visit({15, 1});
    judge();
    EXPECT_TRUE(layer.rooms().empty()) << height;
    EXPECT_EQ(layer.corridors().size(), 1U) << height;
  }
}

TEST_F(Layer, RoomsCorridorsAndTheirFactorsCanBeTurnedOff) {
  plan.box(0, 0, 6, 4);
  plan.add({20, 0}, {40, 0});
  plan.add({40, 2}, {20, 2});
  add_planes();
  const auto with = [&](bool rooms, bool corridors) {
    params.topology.rooms = rooms;
    params.topology.corridors = corridors;
    layer = TopologicalLayer(params);
    visit({1, 1});
    visit({30, 1});
    return std::pair{layer.rooms().size(), layer.corridors().size()};
  };
  EXPECT_EQ(with(false, true), (std::pair<std::size_t, std::size_t>{0, 1}));
  EXPECT_EQ(with(true, false), (std::pair<std::size_t, std::size_t>{1, 0}));
  EXPECT_EQ(with(true, true), (std::pair<std::size_t, std::size_t>{1, 1}));
  const auto factors = [&](bool parallel, bool perpendicular) {
    TopologyParams topology = params.topology;
    topology.parallel_factors = parallel;
    topology.perpendicular_factors = perpendicular;
    std::pair<int, int> count;
    for (const Factor& factor : synchronise_topology(graph, layer, {}, topology).factors) {
      count.first += std::holds_alternative<ParallelPlanes>(factor.data) ? 1 : 0;
      count.second += std::holds_alternative<PerpendicularPlanes>(factor.data) ? 1 : 0;
    }
    return count;
  };
  EXPECT_EQ(factors(true, true), std::pair(3, 4));
  EXPECT_EQ(factors(true, false), std::pair(3, 0));
  EXPECT_EQ(factors(false, true), std::pair(0, 4));
}

// Two stretches of one, known before what lies between them has been seen, are one corridor as soon as they meet.
TEST_F(Layer, StretchesOfACorridorThatMeetAreOne) {
  plan.add({0, 0}, {30, 0});
  plan.add({30, 2}, {0, 2});
  const std::vector<Wall> whole = plan.walls;
  for (Wall& wall : plan.walls) wall.support = clip(wall.support, wall.normal.y() > 0 ? Interval{-10, 0} : Interval{0, 10});
  visit({5, 1});
  plan.walls = whole;
  for (Wall& wall : plan.walls) wall.support = clip(wall.support, wall.normal.y() > 0 ? Interval{-30, -18} : Interval{18, 30});
  visit({24, 1});
  EXPECT_EQ(layer.corridors().size(), 2U);
  plan.walls = whole;
  judge();
  EXPECT_EQ(layer.corridors().size(), 1U);
  EXPECT_NE(log.back().reason.find("it is corridor/0"), std::string::npos);
}

TEST_F(Layer, CrossingCorridorsAreTwo) {
  plan.add({0, 0}, {9, 0});
  plan.add({11, 0}, {24, 0});
  plan.add({9, 2}, {0, 2});
  plan.add({24, 2}, {11, 2});
  plan.add({9, 0}, {9, -10});
  plan.add({11, -10}, {11, 0});
  plan.add({9, 10}, {9, 2});
  plan.add({11, 2}, {11, 10});
  for (double x = 1; x < 24; x += 1) visit({x, 1});
  for (double y = -9; y < 10; y += 1) visit({10, y});
  judge();
  EXPECT_EQ(layer.corridors().size(), 2U);
  EXPECT_TRUE(layer.rooms().empty());
}

TEST_F(Layer, FactorsFollowTheLayer) {
  plan.box(0, 0, 6, 4);
  plan.add({20, 0}, {40, 0});
  plan.add({40, 2}, {20, 2});
  add_planes();
  visit({1, 1});
  visit({30, 1});
  const auto count = [&](auto type) {
    int n = 0;
    for (const auto& [id, factor] : graph.factors()) n += std::holds_alternative<decltype(type)>(factor.data) ? 1 : 0;
    return n;
  };
  ASSERT_TRUE(graph.apply(synchronise_topology(graph, layer, {}, params.topology)).ok());
  EXPECT_EQ(count(RoomPlane{}), 4);
  EXPECT_EQ(count(CorridorPlane{}), 2);
  EXPECT_EQ(count(ParallelPlanes{}), 3);
  EXPECT_EQ(count(PerpendicularPlanes{}), 4);
  const Transaction again = synchronise_topology(graph, layer, {}, params.topology);
  EXPECT_TRUE(again.factors.empty() && again.rooms.empty() && again.remove_factors.empty());  // nothing twice
  plan.walls[0].support = {{0, 0.1}};
  for (int i = 0; i < params.topology.withdraw_after; ++i) judge();
  ASSERT_TRUE(graph.apply(synchronise_topology(graph, layer, {}, params.topology)).ok());
  EXPECT_EQ(count(RoomPlane{}), 0);
  EXPECT_EQ(count(ParallelPlanes{}), 1);
  EXPECT_EQ(count(PerpendicularPlanes{}), 0);
  EXPECT_TRUE(graph.rooms().empty());
}

TEST(Openings, AreWhereTheRobotWalksFromOnePlaceIntoAnother) {
  const std::vector<Place> places{{"corridor/0", {{5, 1}, {10, 2}, 0}}, {"room/0", {{3, 4.15}, {6, 4}, 0}}, {"room/1", {{8, 4.15}, {3.7, 4}, 0}}};
  std::vector<Eigen::Vector3d> path;
  const auto walk = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    for (int i = 0; i <= 50; ++i) path.emplace_back(from.x() + (to.x() - from.x()) * i / 50, from.y() + (to.y() - from.y()) * i / 50, 0.3);
  };
  walk({2, 1}, {2, 4});
  walk({2, 4}, {2.4, 1});
  walk({2.4, 1}, {8, 1});
  walk({8, 1}, {8, 4});
  const auto openings = find_openings(places, path);
  ASSERT_EQ(openings.size(), 2U);
  EXPECT_EQ(openings[0].from, "corridor/0");
  EXPECT_EQ(openings[0].to, "room/0");
  EXPECT_NEAR((openings[0].position - Eigen::Vector3d(2.1, 2.07, 0.3)).norm(), 0, 0.2);
  EXPECT_EQ(openings[1].to, "room/1");
}

TEST(Openings, ALongWayThroughTheUnknownShowsNone) {
  const std::vector<Place> places{{"room/0", {{0, 0}, {4, 4}, 0}}, {"room/1", {{10, 0}, {4, 4}, 0}}};
  std::vector<Eigen::Vector3d> path;
  for (double x = 0; x < 10; x += 0.2) path.emplace_back(x, 0, 0);
  EXPECT_TRUE(find_openings(places, path).empty());
  EXPECT_TRUE(find_openings({}, path).empty());
  EXPECT_TRUE(find_openings(places, {}).empty());
}

}  // namespace
}  // namespace sgraph
