#include "sgraph_slam/ros/map_directory.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

namespace sgraph {
namespace {

namespace fs = std::filesystem;

class MapDirectory : public testing::Test {
 protected:
  void SetUp() override {
    base_ = fs::canonical(fs::temp_directory_path()) / ("sgraph_map_directory_" + std::to_string(getpid()));
    maps_ = base_ / "maps";
    fs::create_directories(maps_ / "house");
    fs::create_directories(base_ / "maps_of_others");
    fs::create_directory_symlink(base_ / "maps_of_others", maps_ / "link_out");
    fs::create_directory_symlink(maps_ / "house", maps_ / "link_in");
  }
  void TearDown() override { fs::remove_all(base_); }

  fs::path base_;
  fs::path maps_;
};

TEST_F(MapDirectory, TakesWhatIsInside) {
  EXPECT_EQ(inside(maps_, ""), maps_);
  EXPECT_EQ(inside(maps_, "."), maps_);
  EXPECT_EQ(inside(maps_.string() + "/", ""), maps_);
  EXPECT_EQ(inside(maps_, "house"), maps_ / "house");
  EXPECT_EQ(inside(maps_, "house/"), maps_ / "house");
  EXPECT_EQ(inside(maps_, "new/floor_2"), maps_ / "new/floor_2");
  EXPECT_EQ(inside(maps_, "house/../other"), maps_ / "other");
  EXPECT_EQ(inside(maps_, "link_in/x"), maps_ / "house/x");
  EXPECT_EQ(inside(maps_, (maps_ / "house").string()), maps_ / "house");
  EXPECT_EQ(inside(maps_, "..name"), maps_ / "..name");
}

TEST_F(MapDirectory, RefusesWhatLeadsOut) {
  for (const char* path : {"..", "../", "../maps_of_others", "house/../..", "house/../../maps_of_others/x", "/", "/etc", "/etc/passwd", "link_out",
                           "link_out/x", "link_out/../../maps_of_others", "new/../../x"})
    EXPECT_FALSE(inside(maps_, path)) << path;
  EXPECT_FALSE(inside(maps_, (base_ / "maps_of_others").string()));  // begins with the same letters
  EXPECT_FALSE(inside(maps_, base_.string()));
}

TEST_F(MapDirectory, WorksBeforeTheDirectoryExists) {
  EXPECT_EQ(inside(base_ / "later", "a"), base_ / "later/a");
  EXPECT_FALSE(inside(base_ / "later", "../a"));
}

}  // namespace
}  // namespace sgraph
