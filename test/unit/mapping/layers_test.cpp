#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>

namespace {

namespace fs = std::filesystem;

// What each folder of the core may not include (docs/architecture.md, dependencies).
const std::map<std::string, std::set<std::string>> forbidden{
    {"types", {"math", "graph", "planes", "places", "loops", "mapping", "pipeline", "io", "odometry", "segmentation", "registration"}},
    {"graph", {"planes", "places", "loops", "mapping", "pipeline", "odometry", "segmentation", "io"}},
    {"planes", {"places", "loops", "mapping", "pipeline", "odometry", "segmentation"}},
    {"loops", {"planes", "places", "mapping", "pipeline", "segmentation"}},
    {"places", {"loops", "mapping", "pipeline", "odometry", "segmentation"}},
    {"mapping", {"pipeline", "odometry", "segmentation"}},
};

TEST(Layers, NoFolderOfTheMappingIncludesWhatIsAboveOrBesideIt) {
  int files = 0;
  for (const std::string root : {"include/sgraph_slam/core/", "src/core/"}) {
    for (const auto& [folder, others] : forbidden) {
      if (!fs::exists(root + folder)) continue;
      for (const auto& entry : fs::recursive_directory_iterator(root + folder)) {
        if (!entry.is_regular_file()) continue;
        ++files;
        std::ifstream file(entry.path());
        for (std::string line; std::getline(file, line);) {
          if (line.rfind("#include", 0) != 0) continue;
          for (const std::string& other : others) {
            EXPECT_EQ(line.find("sgraph_slam/core/" + other + '/'), std::string::npos) << entry.path() << ": " << line;
          }
          EXPECT_EQ(line.find("sgraph_slam/ros/"), std::string::npos) << entry.path() << ": " << line;
        }
      }
    }
  }
  EXPECT_GT(files, 50);
}

}  // namespace
