#include "sgraph_slam/ros/settings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

namespace sgraph {
namespace {

using testing::HasSubstr;

TEST(Settings, ReadsAParameterTree) {
  XmlRpc::XmlRpcValue tree;
  tree["prefilter"]["leaf"] = 0.1;
  tree["prefilter"]["outliers"] = "radius";
  tree["segmentation"]["deep"]["count"] = 7;
  tree["mapping"]["topological_layer"] = false;
  const ParamValues expected{
      {"prefilter.leaf", "0.1"}, {"prefilter.outliers", "radius"}, {"segmentation.deep.count", "7"}, {"mapping.topological_layer", "false"}};
  EXPECT_EQ(to_values(tree), expected);
}

TEST(Settings, NumbersKeepAllTheirDigits) {
  for (const double value : {0.1, 1.0 / 3, 1e-300, 12345678.901234567, -2e20}) {
    XmlRpc::XmlRpcValue tree;
    tree["x"] = value;
    EXPECT_EQ(std::stod(to_values(tree).at("x")), value);
  }
}

TEST(Settings, NoTreeMeansDefaults) { EXPECT_TRUE(to_values(XmlRpc::XmlRpcValue()).empty()); }

// The files that are shipped name only parameters that exist, with values in their range.
TEST(Settings, EveryShippedConfigurationLoads) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator("config")) {
    if (entry.path().extension() != ".yaml") continue;
    ++files;
    Settings settings;
    EXPECT_NO_THROW(apply_values(read_yaml_values(entry.path().string()), [&settings](ParamVisitor& v) {
      settings.params.describe(v);
      v.group("ros", settings.ros, "");
    })) << entry.path();
  }
  EXPECT_GE(files, 10);
}

TEST(Settings, RefusesListsAndNamesAllOfThem) {
  XmlRpc::XmlRpcValue tree;
  tree["a"][0] = 1;
  tree["b"]["c"][0] = 2;
  try {
    to_values(tree);
    FAIL();
  } catch (const ParamError& error) {
    ASSERT_EQ(error.errors().size(), 2U);
    EXPECT_THAT(error.what(), HasSubstr("a: "));
    EXPECT_THAT(error.what(), HasSubstr("b.c: "));
  }
}

TEST(Settings, MountIsYawPitchRoll) {
  const Pose mount = parse_mount(" 0.1 -0.2  0.3 1.5707963267948966 0 0 ");
  EXPECT_EQ(mount.translation, Eigen::Vector3d(0.1, -0.2, 0.3));
  EXPECT_TRUE((mount.rotation * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d::UnitY()));
  const Pose nose_down = parse_mount("0 0 0 0 0.5 0");
  EXPECT_LT((nose_down.rotation * Eigen::Vector3d::UnitX()).z(), 0);
  for (const char* bad : {"", "1 2 3", "0 0 0 0 0 x", "0 0 0 0 0 0 0", "a b c d e f"}) EXPECT_THROW(parse_mount(bad), ParamError) << bad;
}

}  // namespace
}  // namespace sgraph
