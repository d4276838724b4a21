#include "sgraph_slam/core/io/pcd.hpp"

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

TEST(Pcd, ReadsPointsAndDropsInvalidOnes) {
  const auto points =
      read_pcd_positions(written("map.pcd",
                                 "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 3\nHEIGHT 1\n"
                                 "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA ascii\n1 2 3 0\nnan 0 0 0\n-1 0.5 2 7\n"));
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1], Eigen::Vector3f(-1, 0.5f, 2));
  EXPECT_THROW(read_pcd_positions("/nonexistent/map.pcd"), std::runtime_error);
}

std::string refused(const std::string& header, const std::string& data) {
  try {
    read_pcd_positions(written("wrong.pcd", "VERSION 0.7\n" + header + data));
    return {};
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

TEST(Pcd, RefusesHeadersThatContradictTheData) {
  const std::string fields = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n";
  EXPECT_NE(refused(fields + "WIDTH 2\nHEIGHT 1\nPOINTS 2\n", "DATA binary\n0123456789ab").find("2 points are announced, 1 came"), std::string::npos);
  EXPECT_NE(refused(fields + "WIDTH 2\nHEIGHT 9\nPOINTS 2\n", "DATA ascii\n1 2 3\n").find("WIDTH times HEIGHT"), std::string::npos);
  EXPECT_NE(refused(fields + "WIDTH 1\n", "DATA ascii\n1 2\n").find("has 2 values"), std::string::npos);
  EXPECT_NE(refused("FIELDS x y\nSIZE 4 4\nTYPE F F\nWIDTH 1\n", "DATA ascii\n1 2\n").find("no x, y and z"), std::string::npos);
  EXPECT_NE(refused("FIELDS x y z\nSIZE 4\nTYPE F F F\nWIDTH 1\n", "DATA ascii\n1 2 3\n").find("differ in length"), std::string::npos);
  EXPECT_NE(refused(fields, "").find("header doesn't end"), std::string::npos);
}

}  // namespace
}  // namespace sgraph
