#include "sgraph_slam/core/places/topological_layer.hpp"

#include <gtest/gtest.h>

#include "scanned_plan.hpp"

namespace sgraph {
namespace {

class Layer : public testing::Test {
 protected:
  // The plan's walls become planes of the graph, the scans keyframes, as the back end has them.
  void find(const ScannedPlan& scanned) {
    Transaction edit;
    for (const Wall& wall : scanned.plan.walls) {
      if (!graph.find(wall.id)) edit.planes[wall.id] = {{wall.normal.x(), wall.normal.y(), 0}, wall.offset};
    }
    for (const auto& [id, pose] : scanned.poses) {
      if (!graph.find(id)) edit.keyframes[id] = pose;
    }
    ASSERT_TRUE(graph.apply(edit).ok());
    scanned.add_to(layer);
    layer.find(graph, {scanned.plan.walls, scanned.path, {}, 0, {static_cast<std::int64_t>(scanned.poses.size())}, false}, log);
  }

  [[nodiscard]] bool logged(const std::string& what, const std::string& words) const {
    return std::any_of(log.begin(), log.end(), [&](const Decision& d) { return d.what == what && d.reason.find(words) != std::string::npos; });
  }

  PlaceLayerParams params;
  TopologicalLayer layer{params};
  Graph graph;
  DecisionLog log;
};

TEST_F(Layer, KnowsItsPlacesAgain) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {10, 0}, {10, 4}, {0, 4}});
  scanned.wall({5, 0}, {5, 4}, {{1.5, 2.4}});
  scanned.walk({{1, 1}, {3, 1.95}, {7, 1.95}, {9, 3}});
  find(scanned);
  ASSERT_EQ(layer.rooms().size(), 2U);
  ASSERT_EQ(layer.doors().size(), 1U);
  const std::size_t said = log.size();
  find(scanned);
  EXPECT_EQ(layer.rooms().size(), 2U);
  EXPECT_EQ(layer.rooms().count({0}), 1U);
  EXPECT_EQ(layer.rooms().count({1}), 1U);
  EXPECT_EQ(layer.doors().count({0}), 1U);
  EXPECT_EQ(log.size(), said);  // nothing new to say
  EXPECT_TRUE(layer.covers({2, 2}));
  EXPECT_FALSE(layer.covers({12, 2}));
}

TEST_F(Layer, ARoomThatTurnsOutLargerKeepsItsName) {
  ScannedPlan first;
  first.face({{0, 0}, {6, 0}, {6, 4}, {0, 4}});
  first.walk({{1, 1}, {5, 3}});
  find(first);
  ASSERT_EQ(layer.rooms().size(), 1U);
  // The wall at x = 6 was a screen: it is gone, and the room goes on.
  ScannedPlan later;
  later.face({{0, 0}, {9, 0}, {9, 4}, {0, 4}});
  later.walk({{1, 1}, {8, 3}, {7, 1}, {5, 2}, {8, 2}});
  TopologicalLayer fresh{params};
  later.add_to(fresh);
  layer.find(graph, {later.plan.walls, later.path, {}, 0, {100}, false}, log);
  EXPECT_EQ(layer.rooms().size(), 1U);
  EXPECT_EQ(layer.rooms().count({0}), 1U);
}

TEST_F(Layer, WhatIsLostKeepsItsNameForLater) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {6, 0}, {6, 4}, {0, 4}});
  scanned.walk({{1, 1}, {5, 3}});
  find(scanned);
  ASSERT_EQ(layer.rooms().count({0}), 1U);
  layer.find(graph, {scanned.plan.walls, {}, {}, 0, {50}, false}, log);  // nobody has been in it
  EXPECT_TRUE(layer.rooms().empty());
  EXPECT_TRUE(logged("room/0", "withdrawn"));
  find(scanned);
  EXPECT_EQ(layer.rooms().count({0}), 1U);
  EXPECT_TRUE(logged("room/0", "found again"));
}

TEST_F(Layer, SwitchesTurnKindsOff) {
  params.topology.rooms = false;
  layer = TopologicalLayer{params};
  ScannedPlan scanned;
  scanned.face({{0, 0}, {6, 0}, {6, 4}, {0, 4}});
  scanned.walk({{1, 1}, {5, 3}});
  find(scanned);
  EXPECT_TRUE(layer.rooms().empty());
}

TEST_F(Layer, PlanesSeenLatelyAlongASideMayBeItsWall) {
  ScannedPlan scanned;
  scanned.face({{0, 0}, {6, 0}, {6, 4}, {0, 4}});
  scanned.walk({{1, 1}, {5, 3}});
  find(scanned);
  std::vector<Wall> walls = scanned.plan.walls;
  Wall again = walls[0];  // the same wall, seen with drift
  again.id = {99};
  again.offset += 0.2;
  again.last_seen = {30};
  walls.push_back(again);
  const std::vector<PlanePair> pairs = layer.shown_at(walls, {3, 2}, {31});
  ASSERT_EQ(pairs.size(), 1U);
  EXPECT_EQ(pairs[0], (PlanePair{{0}, {99}}));
  EXPECT_TRUE(layer.shown_at(walls, {30, 2}, {31}).empty());  // elsewhere
}

}  // namespace
}  // namespace sgraph
