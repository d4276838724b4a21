#include "sgraph_slam/core/io/storey_view.hpp"

#include <gtest/gtest.h>

#include "sgraph_slam/core/io/graph_json.hpp"

namespace sgraph {
namespace {

// Two keyframes on each of two storeys and one on the stairs, a floor and a room on each.
GraphSnapshot building() {
  GraphSnapshot map;
  const int storeys[] = {0, 0, stairwell, 1, 1};
  const double heights[] = {0, 0, 1.5, 3, 3};
  for (std::int64_t k = 0; k < 5; ++k) {
    SceneKeyframe& keyframe = map.keyframes[{k}];
    keyframe.id = {k};
    keyframe.stamp = {1000 * k};
    keyframe.T_map_base.translation = {static_cast<double>(k), 0, heights[k]};
    keyframe.storey = storeys[k];
    keyframe.scans = Trajectory{{{1000 * k - 500}, {}}, {{1000 * k}, {}}};
  }
  for (std::int64_t k = 0; k < 2; ++k) {
    ScenePlane& floor = map.planes[{k}];
    floor.id = {k};
    floor.plane = {Eigen::Vector3d::UnitZ(), -3.0 * static_cast<double>(k)};
    const double z = 3.0 * static_cast<double>(k);
    floor.extent = {{0, 0, z}, {4, 0, z}, {4, 4, z}};
    floor.storey = static_cast<int>(k);
    SceneCorridor& corridor = map.corridors[{k}];
    corridor.id = {k};
    corridor.center = {2, 2, z + 1};
    corridor.storey = static_cast<int>(k);
    map.storeys.push_back({static_cast<int>(k), z, z + 2.5, true});
  }
  map.openings = {{"corridor/1", "corridor/1", {}}};
  return map;
}

TEST(StoreyView, TakesOneStoreyOutOfAMap) {
  const GraphSnapshot map = building();
  EXPECT_EQ(storeys_of(map), (std::set<int>{0, 1}));
  const GraphSnapshot upper = of_storey(map, 1);
  EXPECT_EQ(upper.keyframes.size(), 2U);
  EXPECT_EQ(upper.planes.count({1}), 1U);
  EXPECT_EQ(upper.planes.size(), 1U);
  EXPECT_EQ(upper.corridors.begin()->first, CorridorId{1});
  EXPECT_EQ(upper.openings.size(), 1U);
  EXPECT_TRUE(of_storey(map, 0).openings.empty());
  Trajectory path;
  for (std::int64_t t = -500; t <= 4000; t += 500) path.push_back({{t}, {}});
  EXPECT_EQ(path_of(upper, path).size(), 4U);
}

TEST(StoreyView, DrawsStoreysApart) {
  const GraphSnapshot map = exploded(building(), 10);
  EXPECT_NEAR(map.keyframes.at({0}).T_map_base.translation.z(), 0, 1e-9);
  EXPECT_NEAR(map.keyframes.at({2}).T_map_base.translation.z(), 1.5 + 5, 1e-9);  // half way up the stairs
  EXPECT_NEAR(map.keyframes.at({4}).T_map_base.translation.z(), 3 + 10, 1e-9);
  EXPECT_NEAR(map.planes.at({1}).extent[0].z(), 13, 1e-9);
  EXPECT_NEAR(map.planes.at({1}).plane.distance(map.planes.at({1}).extent[0]), 0, 1e-9);
  EXPECT_NEAR(map.corridors.at({1}).center.z(), 14, 1e-9);
}

TEST(StoreyView, GraphJsonKeepsStoreys) {
  GraphSnapshot map = building();
  map.openings.clear();
  const GraphSnapshot back = parse_graph_json(graph_json(map));
  for (const auto& [id, keyframe] : map.keyframes) EXPECT_EQ(back.keyframes.at(id).storey, keyframe.storey);
  for (const auto& [id, plane] : map.planes) EXPECT_EQ(back.planes.at(id).storey, plane.storey);
}

}  // namespace
}  // namespace sgraph
