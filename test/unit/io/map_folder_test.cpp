#include "sgraph_slam/core/io/map_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "sgraph_slam/core/io/file.hpp"
#include "sgraph_slam/core/io/graph_json.hpp"
#include "sgraph_slam/core/io/map_cloud.hpp"
#include "sgraph_slam/core/io/pcd.hpp"
#include "sgraph_slam/core/io/tum.hpp"
#include "small_room.hpp"

namespace sgraph {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class FolderTest : public testing::Test {
 protected:
  FolderTest() : folder_(fs::temp_directory_path() / ("map_folder_test." + std::to_string(getpid()))) { fs::create_directories(folder_); }
  ~FolderTest() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  static std::string error_of(const std::function<void()>& act) {
    try {
      act();
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }
  fs::path folder_;
};

TEST_F(FolderTest, FilesAreWrittenWhole) {
  const std::string bytes("a\0b\n", 4);
  write_file(path("x"), "something longer");
  write_file(path("x"), bytes);
  EXPECT_EQ(read_file(path("x")), bytes);
  EXPECT_FALSE(fs::exists(path("x.part")));
}

TEST_F(FolderTest, AFullDiskIsNamedAndLeavesTheOldFile) {
  write_file(path("map.pcd"), "old");
  fs::create_symlink("/dev/full", path("map.pcd.part"));
  EXPECT_THAT(error_of([&] { write_file(path("map.pcd"), std::string(100'000, 'x')); }),
              testing::AllOf(HasSubstr("map.pcd"), HasSubstr("No space left")));
  EXPECT_EQ(read_file(path("map.pcd")), "old");
}

TEST_F(FolderTest, FoldersThatCannotBeMadeAreNamed) {
  write_file(path("file"), "");
  EXPECT_THAT(error_of([&] { make_folder(path("file")); }), HasSubstr("file"));
  EXPECT_THAT(error_of([&] { make_folder(path("file/below")); }), HasSubstr("Not a directory"));
  EXPECT_THAT(error_of([&] { write_file(path("missing/file"), ""); }), HasSubstr("No such file or directory"));
  EXPECT_THAT(error_of([&] { read_file(path("missing")); }), HasSubstr("No such file or directory"));
  make_folder(path("a/b/c"));
  make_folder(path("a/b/c"));
  EXPECT_TRUE(fs::is_directory(path("a/b/c")));
}

TEST_F(FolderTest, AMapHasAllItsFiles) {
  const SmallRoom room(0.3);
  const Trajectory path_walked{{{1}, Pose()}, {{2}, Pose{Eigen::Quaterniond::Identity(), {1, 0, 0}}}};
  write_map(path("map"), room.snapshot, path_walked, room.T_base_lidar(), OutputParams());
  for (const char* name :
       {"graph.json", "keyframes.tum", "map.pcd", "map.pgm", "map.yaml", "floor_plan.png", "floor_plan.svg", "floor_plan.dxf", "decisions.csv"}) {
    EXPECT_GT(fs::file_size(path(std::string("map/") + name)), 25U) << name;
  }
  EXPECT_EQ(parse_graph_json(read_file(path("map/graph.json"))).rooms.size(), 1U);
  const Trajectory keyframes = read_tum(path("map/keyframes.tum"));
  ASSERT_EQ(keyframes.size(), 1U);
  EXPECT_EQ(keyframes[0].stamp.nanoseconds, 1'700'000'000'123'456'789);
  EXPECT_LT((keyframes[0].pose.translation - room.snapshot.keyframes.at({0}).T_map_base.translation).norm(), 1e-6);
}

TEST(Decisions, AreARowEachWhateverTheWords) {
  EXPECT_EQ(decisions_csv({{{3}, true, "room/0", "four walls (planes 1, 2, 3, 4)"}, {{7}, false, "plane/9", "a \"ghost\""}}),
            "keyframe,verdict,what,reason\n3,accepted,\"room/0\",\"four walls (planes 1, 2, 3, 4)\"\n7,refused,\"plane/9\",\"a \"\"ghost\"\"\"\n");
}

TEST_F(FolderTest, TheMapCloudIsWhereTheGraphHasIt) {
  const SmallRoom room(0.3);
  const Cloud all = map_cloud(room.snapshot, room.T_base_lidar(), 0);
  EXPECT_EQ(all.size() + 1, room.snapshot.keyframes.at({0}).cloud.get()->size());  // all but the one that is not a number
  int on_planes = 0;
  for (const Point& p : all.points) {
    for (const auto& [id, plane] : room.snapshot.planes) on_planes += std::abs(plane.plane.distance(p.position().cast<double>())) < 1e-4 ? 1 : 0;
  }
  EXPECT_GT(on_planes, static_cast<int>(0.8 * static_cast<double>(all.size())));

  write_file(path("map.pcd"), pcd_bytes(all));
  const auto positions = read_pcd_positions(path("map.pcd"));
  ASSERT_EQ(positions.size(), all.size());
  for (std::size_t i = 0; i < positions.size(); ++i) EXPECT_EQ(positions[i], all.points[i].position());
}

TEST_F(FolderTest, TheMapCloudIsThinned) {
  const SmallRoom room;
  for (const double leaf : {0.05, 0.2}) {
    const Cloud thin = map_cloud(room.snapshot, room.T_base_lidar(), leaf);
    std::set<std::array<int, 3>> voxels;
    for (const Point& p : thin.points) {
      // Coordinates that rounding put onto a voxel's side may count for either.
      voxels.insert({static_cast<int>(std::floor(p.x / leaf)), static_cast<int>(std::floor(p.y / leaf)), static_cast<int>(std::floor(p.z / leaf))});
    }
    EXPECT_GT(voxels.size(), 0.97 * static_cast<double>(thin.size()));
    EXPECT_LT(thin.size(), map_cloud(room.snapshot, room.T_base_lidar(), 0).size());
  }
  GraphSnapshot without_clouds = room.snapshot;
  for (auto& [id, keyframe] : without_clouds.keyframes) keyframe.cloud = nullptr;
  EXPECT_TRUE(map_cloud(without_clouds, room.T_base_lidar(), 0.05).empty());
}

TEST_F(FolderTest, TheMapCloudIsFreeOfTheNoiseBesideAWall) {
  auto cloud = std::make_shared<Cloud>();
  const auto add = [&cloud](float x, float y, float z) {
    Point point;
    point.set_position({x, y, z});
    cloud->points.push_back(point);
  };
  // A wall at x = 2.025 in the middle of its voxels, 100 points in each, off it by up to 1 cm to either side; one stray in fifty lies 6 cm before it.
  for (int i = 0; i < 2000; ++i) {
    const auto y = 0.0005F * static_cast<float>(i);
    for (const float z : {0.01F, 0.04F}) add(2.025F + (i % 2 == 0 ? 0.01F : -0.01F), y, z);
    if (i % 100 == 50) add(1.965F, y, 0.02F);
  }
  // Far from any wall a single point says all that is known.
  add(5, 5, 1);
  GraphSnapshot snapshot;
  SceneKeyframe keyframe;
  keyframe.cloud = cloud;
  snapshot.keyframes[{0}] = keyframe;
  const Cloud map = map_cloud(snapshot, Pose{}, 0.05);
  ASSERT_EQ(map.size(), 21u);
  for (std::size_t i = 0; i < 20; ++i) EXPECT_NEAR(map.points[i].x, 2.025, 0.001) << i;
  EXPECT_EQ(map.points.back().position(), Eigen::Vector3f(5, 5, 1));
}

TEST_F(FolderTest, TheFloorIsTheLargestPlaneBelow) {
  SmallRoom room;
  SceneKeyframe& keyframe = room.snapshot.keyframes.at({0});
  ScenePlane table;
  table.id = {20};
  table.plane = {Eigen::Vector3d::UnitZ(), -0.7};
  table.plane_class = PlaneClass::horizontal;
  table.extent = {{0, 0, 0.7}, {1, 0, 0.7}, {1, 1, 0.7}, {0, 1, 0.7}};
  table.keyframes = {{0}};
  room.snapshot.planes[table.id] = table;
  EXPECT_NEAR(floor_below(room.snapshot, keyframe, room.T_base_lidar())->d, 0, 1e-9);

  // No floor among the planes: the cloud's lowest points stand in for it.
  room.snapshot.planes.clear();
  EXPECT_NEAR(floor_below(room.snapshot, keyframe, room.T_base_lidar())->d, 0, 1e-3);
  keyframe.cloud = nullptr;
  EXPECT_FALSE(floor_below(room.snapshot, keyframe, room.T_base_lidar()));
}

}  // namespace
}  // namespace sgraph
