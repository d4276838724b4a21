#include "sgraph_slam/core/io/map_files.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <stdexcept>

namespace sgraph {
namespace {

std::string written(const std::string& name, const std::string& text) {
  const std::string path = testing::TempDir() + name;
  std::ofstream(path) << text;
  return path;
}

TEST(MapFiles, ReadsTheLayersOfAGraph) {
  const Structure s = read_structure(written("graph.json", R"({"format": 1, "frame": "map", "keyframes": [], "factors": [],
    "planes": [{"id": 4, "class": "y", "normal": [0, 1, 0], "d": -2.5, "extent": [[0, 2.5, 0], [1, 2.5, 0], [1, 2.5, 2]], "keyframes": [0, 3]}],
    "rooms": [{"id": 1, "center": [1, 2, 1.4], "width": [3, 4], "yaw": 0.1, "planes": [1, 2, 3, 4]}],
    "corridors": [{"id": 0, "center": [5, 6, 1], "width": [2], "yaw": -0.2, "length": 12, "planes": [5, 6]}]})"));
  ASSERT_EQ(s.planes.size(), 1u);
  EXPECT_EQ(s.planes[0].id.value, 4);
  EXPECT_EQ(s.planes[0].plane_class, PlaneClass::y);
  EXPECT_DOUBLE_EQ(s.planes[0].plane.distance({0, 3, 0}), 0.5);
  EXPECT_EQ(s.planes[0].extent.size(), 3u);
  EXPECT_EQ(s.planes[0].keyframes.size(), 2u);
  ASSERT_EQ(s.rooms.size(), 1u);
  EXPECT_DOUBLE_EQ(s.rooms[0].width.y(), 4);
  EXPECT_EQ(s.rooms[0].planes.size(), 4u);
  ASSERT_EQ(s.corridors.size(), 1u);
  EXPECT_DOUBLE_EQ(s.corridors[0].width, 2);
  EXPECT_DOUBLE_EQ(s.corridors[0].length, 12);
}

TEST(MapFiles, RefusesBrokenGraphs) {
  EXPECT_THROW(read_structure("/nonexistent/graph.json"), std::runtime_error);
  for (const char* bad : {"", "{}", R"({"planes": [{"id": 4}], "rooms": [], "corridors": []})", R"({"planes": 3, "rooms": [], "corridors": []})"}) {
    EXPECT_THROW(read_structure(written("bad_graph.json", bad)), std::runtime_error) << bad;
  }
}

TEST(MapFiles, ReadsPointsAndDropsInvalidOnes) {
  const auto points =
      read_pcd_positions(written("map.pcd",
                                 "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 3\nHEIGHT 1\n"
                                 "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n1 2 3 0\nnan 0 0 0\n-1 0.5 2 7\n"));
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1], Eigen::Vector3f(-1, 0.5f, 2));
  EXPECT_THROW(read_pcd_positions("/nonexistent/map.pcd"), std::runtime_error);
}

}  // namespace
}  // namespace sgraph
