#include "sgraph_slam/ros/markers.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

namespace sgraph {
namespace {

constexpr double layer = 10;

ScenePlane wall(std::int64_t id, const Plane& plane, PlaneClass plane_class, const std::vector<Eigen::Vector3d>& extent) {
  ScenePlane result;
  result.id = {id};
  result.plane = plane;
  result.plane_class = plane_class;
  result.extent = extent;
  result.keyframes = {{0}};
  return result;
}

/// Two keyframes, two walls, a floor, and a corridor between the walls.
GraphSnapshot small_graph() {
  GraphSnapshot graph;
  graph.frame = "site";
  for (std::int64_t i = 0; i < 2; ++i) {
    SceneKeyframe keyframe;
    keyframe.id = {i};
    keyframe.stamp = {1'000'000'000 * (i + 1)};
    keyframe.T_map_base.translation = {static_cast<double>(i), 0, 0.5};
    graph.keyframes[keyframe.id] = keyframe;
  }
  const double y = 1;
  graph.planes[{0}] = wall(0, {{0, 1, 0}, y}, PlaneClass::y, {{-2, -y, 0}, {2, -y, 0}, {2, -y, 2}, {-2, -y, 2}});
  graph.planes[{1}] = wall(1, {{0, -1, 0}, y}, PlaneClass::y, {{-2, y, 0}, {2, y, 0}, {2, y, 2}, {-2, y, 2}});
  graph.planes[{2}] = wall(2, {{0, 0, 1}, 0}, PlaneClass::horizontal, {{-2, -y, 0}, {2, -y, 0}, {2, y, 0}, {-2, y, 0}});
  graph.corridors[{4}] = {{4}, {0, 0, 1}, 2.0, 0, 4.0, {{0}, {1}}};
  return graph;
}

using Markers = std::multimap<std::string, visualization_msgs::Marker>;

Markers by_name(const visualization_msgs::MarkerArray& array) {
  Markers result;
  for (const auto& marker : array.markers) result.emplace(marker.ns, marker);
  return result;
}

TEST(Markers, BeginWithAnEraser) {
  const auto array = graph_markers({}, layer);
  ASSERT_EQ(array.markers.size(), 1U);
  EXPECT_EQ(array.markers[0].action, visualization_msgs::Marker::DELETEALL);
}

TEST(Markers, LayersLieAboveEachOther) {
  const Markers markers = by_name(graph_markers(small_graph(), layer));
  const auto keyframes = markers.find("keyframes")->second;
  ASSERT_EQ(keyframes.points.size(), 2U);
  EXPECT_DOUBLE_EQ(keyframes.points[1].z, 0.5);
  EXPECT_EQ(keyframes.header.frame_id, "site");
  EXPECT_EQ(keyframes.header.stamp, ros::Time(2));
  EXPECT_EQ(markers.count("planes"), 2U);  // the floor is drawn as an outline only
  EXPECT_EQ(markers.count("plane_outlines"), 3U);
  for (const auto& [name, marker] : markers) {
    if (name != "planes") continue;
    EXPECT_EQ(marker.points.size(), 6U);  // two triangles
    EXPECT_EQ(marker.colors.size(), 6U);
    for (const auto& point : marker.points) {
      EXPECT_GE(point.z, layer);
      EXPECT_LE(point.z, layer + 2);
    }
  }
  EXPECT_DOUBLE_EQ(markers.find("corridors")->second.pose.position.z, 2 * layer + 1);
}

TEST(Markers, SmallPlanesAreTonedDownUnlessTheyBoundAPlace) {
  GraphSnapshot graph = small_graph();
  graph.planes[{3}] = wall(3, {{1, 0, 0}, 0}, PlaneClass::x, {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}});
  Markers markers = by_name(graph_markers(graph, layer));
  EXPECT_EQ(markers.count("planes"), 2U);
  ASSERT_EQ(markers.count("small_planes"), 1U);
  EXPECT_EQ(markers.find("small_planes")->second.id, 3);
  graph.corridors[{4}].planes = {{0}, {3}};
  markers = by_name(graph_markers(graph, layer));
  EXPECT_EQ(markers.count("planes"), 3U);
  EXPECT_EQ(markers.count("small_planes"), 0U);
}

TEST(Markers, PlacesAreLinkedToTheirWallsAndSayTheirSize) {
  GraphSnapshot graph = small_graph();
  Markers markers = by_name(graph_markers(graph, layer));
  const auto links = markers.find("corridors_walls")->second;
  ASSERT_EQ(links.points.size(), 4U);
  EXPECT_DOUBLE_EQ(links.points[1].y, -1);
  EXPECT_DOUBLE_EQ(links.points[1].z, layer + 1);
  EXPECT_DOUBLE_EQ(links.points[3].y, 1);
  EXPECT_EQ(markers.find("corridors_labels")->second.text, "corridor 4\n2.00 m wide");

  graph.corridors.at({4}).planes[1] = {99};  // a wall that is not in the graph: no line into nowhere
  markers = by_name(graph_markers(graph, layer));
  EXPECT_EQ(markers.find("corridors_walls")->second.points.size(), 2U);
}

// A map grows at one place: what stays as it is isn't sent again.
TEST(Markers, OnlyWhatChangedIsSentAgain) {
  using visualization_msgs::Marker;
  GraphSnapshot graph = small_graph();
  MarkerChanges changes;
  const auto first = graph_markers(graph, layer);
  EXPECT_EQ(changes.since_last(first, false).markers.size(), first.markers.size() - 1);  // all but the eraser
  graph.keyframes.at({1}).stamp = {9'000'000'000};
  graph.keyframes.at({1}).T_map_base.translation.x() += 0.001;
  EXPECT_TRUE(changes.since_last(graph_markers(graph, layer), false).markers.empty());
  graph.planes.at({2}).extent[0].x() -= 0.5;
  auto changed = changes.since_last(graph_markers(graph, layer), false);
  ASSERT_EQ(changed.markers.size(), 1U);
  EXPECT_EQ(changed.markers[0].ns, "plane_outlines");
  EXPECT_EQ(changed.markers[0].id, 2);
  graph.planes.erase({2});
  changed = changes.since_last(graph_markers(graph, layer), false);
  ASSERT_EQ(changed.markers.size(), 1U);
  EXPECT_EQ(changed.markers[0].action, Marker::DELETE);
  EXPECT_EQ(changed.markers[0].ns, "plane_outlines");
  EXPECT_EQ(changed.markers[0].header.frame_id, "site");
  const auto whole = changes.since_last(graph_markers(graph, layer), true);
  EXPECT_EQ(whole.markers.size(), graph_markers(graph, layer).markers.size());
  EXPECT_EQ(whole.markers[0].action, Marker::DELETEALL);
}

// In a corridor of 100 m the line to a wall's middle would end in another room.
TEST(Markers, PlacesAreLinkedToTheNearestPointOfTheirWalls) {
  GraphSnapshot graph = small_graph();
  for (Eigen::Vector3d& corner : graph.planes.at({0}).extent)
    if (corner.x() > 0) corner.x() = 98;
  const auto links = by_name(graph_markers(graph, layer)).find("corridors_walls")->second;
  ASSERT_EQ(links.points.size(), 4U);
  EXPECT_NEAR(links.points[1].x, 0, 1e-12);
  EXPECT_NEAR(links.points[1].y, -1, 1e-12);
  EXPECT_NEAR(links.points[1].z, layer + 1, 1e-12);
}

TEST(Markers, DoorsAreNodesBetweenThePlacesThatTheyJoin) {
  GraphSnapshot graph = small_graph();
  graph.rooms[{3}] = {{3}, {5, 0, 1}, {4, 4}, 0, {{0}, {1}, {0}, {1}}};
  graph.openings = {{"room/3", "corridor/4", {2, 0, 1}}};
  graph.doors[{0}] = {{0}, "corridor/4", "room/3", {2, 0, 0}, 0, 0.9, 2.1};
  graph.doors[{1}] = {{1}, "corridor/4", "", {-2, 0, 0}, 0, 0.9, 0};  // nobody has been behind it
  const Markers markers = by_name(graph_markers(graph, layer));
  EXPECT_EQ(markers.count("openings"), 0U);  // the door joins them
  EXPECT_EQ(markers.find("doors")->second.points.size(), 16U);
  const auto nodes = markers.find("door_nodes")->second;
  ASSERT_EQ(nodes.points.size(), 2U);
  EXPECT_DOUBLE_EQ(nodes.points[0].z, layer + 2.1);
  const auto edges = markers.find("door_edges")->second;
  ASSERT_EQ(edges.points.size(), 6U);
  EXPECT_DOUBLE_EQ(edges.points[2].x, 5);
  EXPECT_DOUBLE_EQ(edges.points[2].z, 2 * layer + 1);
  EXPECT_DOUBLE_EQ(edges.points[3].x, 2);
}

TEST(Markers, StoreysAreNodesAboveTheirPlaces) {
  GraphSnapshot graph = small_graph();
  graph.storeys = {{0, 0.0, 2.5, true}};
  EXPECT_EQ(by_name(graph_markers(graph, layer)).count("storeys"), 0U);
  graph.storeys.push_back({1, 3.0, 5.5, true});
  graph.storeys.push_back({2, 6.0, 8.5, true});  // no place there yet
  graph.rooms[{3}] = {{3}, {5, 0, 4}, {4, 4}, 0, {}};
  graph.rooms.at({3}).storey = 1;
  const Markers markers = by_name(graph_markers(graph, layer));
  ASSERT_EQ(markers.count("storeys"), 2U);
  EXPECT_EQ(markers.count("storeys_labels"), 2U);
  for (const auto& [name, marker] : markers) {
    if (name == "storeys") {
      EXPECT_DOUBLE_EQ(marker.pose.position.z, 3 * layer + (marker.id == 0 ? 1 : 4));
    }
    if (name == "storeys_places") {
      EXPECT_EQ(marker.points.size(), 2U);
    }
  }
}

TEST(Markers, OpeningsJoinThePlacesTheyName) {
  GraphSnapshot graph = small_graph();
  graph.rooms[{3}] = {{3}, {5, 0, 1}, {4, 4}, 0, {{0}, {1}, {0}, {1}}};
  graph.openings = {{"room/3", "corridor/4", {2, 0, 1}}, {"room/7", "corridor/4", {0, 0, 0}}, {"nonsense", "", {0, 0, 0}}};
  const Markers markers = by_name(graph_markers(graph, layer));
  const auto openings = markers.find("openings")->second;
  ASSERT_EQ(openings.points.size(), 2U);
  EXPECT_DOUBLE_EQ(openings.points[0].x, 5);
  EXPECT_DOUBLE_EQ(openings.points[1].x, 0);
}

}  // namespace
}  // namespace sgraph
