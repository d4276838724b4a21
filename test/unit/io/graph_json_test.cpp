#include "sgraph_slam/core/io/graph_json.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "sgraph_slam/core/math/se3.hpp"

namespace sgraph {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class RandomSnapshot {
 public:
  explicit RandomSnapshot(unsigned seed) : random_(seed) {
    snapshot.version = 1 + static_cast<std::int64_t>(seed);
    snapshot.T_map_odom = pose();
    snapshot.dominant_yaw = number();
    std::int64_t ns = 1'700'000'000'000'000'001;
    for (std::int64_t i = 0; i < 12; ++i) {
      SceneKeyframe keyframe;
      keyframe.id = {3 * i};
      Trajectory scans;
      for (int k = 0; k < 5; ++k) scans.push_back({{ns += 99'999'999}, pose()});
      keyframe.scans = std::move(scans);
      keyframe.stamp = {ns};
      keyframe.T_map_base = pose();
      keyframe.T_odom_base = pose();
      snapshot.keyframes.emplace(keyframe.id, keyframe);
    }
    for (std::int64_t i = 0; i < 9; ++i) {
      ScenePlane plane;
      plane.id = {i * i};
      plane.plane = {point().normalized(), number()};
      plane.plane_class = static_cast<PlaneClass>(i % 4);
      for (int k = 0; k < 9; ++k) plane.covariance.data()[k] = number();
      for (int k = 0; k < 4; ++k) plane.extent.push_back(point());
      plane.keyframes = {{0}, {3 * i}};
      snapshot.planes.emplace(plane.id, plane);
    }
    snapshot.rooms[{2}] = {{2}, point(), {number(), number()}, number(), {{0}, {1}, {4}, {9}}};
    snapshot.corridors[{5}] = {{5}, point(), number(), number(), number(), {{16}, {25}}};
    snapshot.openings.push_back({"room/2", "corridor/5", point()});
    SceneRoom hall;  // without a width
    hall.id = {3};
    hall.planes = {{0}, {4}};
    hall.polygon = {{0, 0}, {number(), 0}, {number(), number()}};
    hall.edges = {{SceneSide::Kind::wall, {4}, {}}, {SceneSide::Kind::door, {}, {1}}, {}};
    hall.storey = 1;
    hall.holes = {{{1, 1}, {1, number()}, {2, 2}}};
    snapshot.rooms[hall.id] = hall;
    SceneBranching branching;
    branching.parts = {{0}};
    branching.polygon = hall.polygon;
    branching.edges = hall.edges;
    branching.holes = {{{3, 1}, {3, number()}, {4, 2}}};
    snapshot.branchings.push_back(branching);
    snapshot.doors[{1}] = {{1}, "room/2", "room/3", point(), number(), 0.9, 2.05, 1};
    snapshot.storeys.push_back({1, number(), number(), true});
    snapshot.factors_json = R"([{"id":0,"type":"odometry","pose":[0.1,1e-300,3]}])";
  }

  GraphSnapshot snapshot;

 private:
  double number() { return std::normal_distribution<double>(0, 10)(random_); }
  Eigen::Vector3d point() { return {number(), number(), number()}; }
  Pose pose() {
    Vector6 xi;
    for (int k = 0; k < 6; ++k) xi[k] = 0.1 * number();
    return se3_exp(xi);
  }
  std::mt19937 random_;
};

void expect_same(const Pose& a, const Pose& b) {
  EXPECT_EQ(a.translation, b.translation);
  EXPECT_EQ(a.rotation.coeffs(), b.rotation.coeffs());
}

TEST(GraphJson, ReadsBackExactly) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const GraphSnapshot original = RandomSnapshot(seed).snapshot;
    const std::string text = graph_json(original);
    const GraphSnapshot copy = parse_graph_json(text);
    EXPECT_EQ(graph_json(copy), text);
    EXPECT_EQ(copy.version, original.version);
    expect_same(copy.T_map_odom, original.T_map_odom);
    ASSERT_EQ(copy.keyframes.size(), original.keyframes.size());
    for (const auto& [id, keyframe] : original.keyframes) {
      const SceneKeyframe& same = copy.keyframes.at(id);
      EXPECT_EQ(same.stamp, keyframe.stamp);
      expect_same(same.T_map_base, keyframe.T_map_base);
      expect_same(same.T_odom_base, keyframe.T_odom_base);
      ASSERT_EQ(same.scans->size(), keyframe.scans->size());
      for (std::size_t i = 0; i < keyframe.scans->size(); ++i) {
        EXPECT_EQ((*same.scans)[i].stamp, (*keyframe.scans)[i].stamp);
        expect_same((*same.scans)[i].pose, (*keyframe.scans)[i].pose);
      }
    }
    ASSERT_EQ(copy.planes.size(), original.planes.size());
    for (const auto& [id, plane] : original.planes) {
      const ScenePlane& same = copy.planes.at(id);
      EXPECT_EQ(same.plane.normal, plane.plane.normal);
      EXPECT_EQ(same.plane.d, plane.plane.d);
      EXPECT_EQ(same.plane_class, plane.plane_class);
      EXPECT_EQ(same.covariance, plane.covariance);
      EXPECT_EQ(same.extent, plane.extent);
      EXPECT_EQ(same.keyframes, plane.keyframes);
    }
    const SceneRoom& room = copy.rooms.at({2});
    EXPECT_EQ(room.center, original.rooms.at({2}).center);
    EXPECT_EQ(room.width, original.rooms.at({2}).width);
    EXPECT_EQ(room.planes, original.rooms.at({2}).planes);
    const SceneCorridor& corridor = copy.corridors.at({5});
    EXPECT_EQ(corridor.width, original.corridors.at({5}).width);
    EXPECT_EQ(corridor.length, original.corridors.at({5}).length);
    EXPECT_EQ(copy.openings.at(0).to, "corridor/5");
    EXPECT_EQ(json::parse(copy.factors_json), json::parse(original.factors_json));
  }
}

// Other programs rely on these names.
TEST(GraphJson, HasTheFixedFields) {
  const json graph = json::parse(graph_json(RandomSnapshot(1).snapshot));
  EXPECT_EQ(graph.at("format"), 1);
  EXPECT_EQ(graph.at("frame"), "map");
  EXPECT_EQ(graph.at("keyframes").at(0).at("pose").size(), 7U);
  EXPECT_NEAR(graph.at("keyframes").at(0).at("stamp").get<double>(), 1'700'000'000.5, 1e-3);
  EXPECT_EQ(graph.at("planes").at(0).at("class"), "x");
  EXPECT_EQ(graph.at("planes").at(3).at("class"), "unclassified");
  EXPECT_EQ(graph.at("planes").at(0).at("normal").size(), 3U);
  EXPECT_EQ(graph.at("planes").at(0).at("extent").at(0).size(), 3U);
  EXPECT_EQ(graph.at("rooms").at(0).at("planes").size(), 4U);
  EXPECT_EQ(graph.at("rooms").at(0).at("width").size(), 2U);
  EXPECT_EQ(graph.at("corridors").at(0).at("width").size(), 1U);
  EXPECT_TRUE(graph.at("corridors").at(0).at("length").is_number());
  EXPECT_EQ(graph.at("factors").at(0).at("type"), "odometry");
}

TEST(GraphJson, AnEmptyMapIsAMap) {
  const GraphSnapshot copy = parse_graph_json(graph_json(GraphSnapshot()));
  EXPECT_TRUE(copy.keyframes.empty());
  EXPECT_EQ(copy.frame, "map");
}

TEST(GraphJson, DamageIsAnErrorThatNamesIt) {
  const std::string text = graph_json(RandomSnapshot(2).snapshot);
  const auto error_of = [](const std::string& damaged) -> std::string {
    try {
      parse_graph_json(damaged);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  const json graph = json::parse(text);
  for (const auto& [key, value] : graph.items()) {
    json less = graph;
    less.erase(key);
    if (key == "places" || key == "doors" || key == "storeys") {  // graphs written before places had outlines have none
      EXPECT_EQ(error_of(less.dump()), "");
    } else {
      EXPECT_THAT(error_of(less.dump()), HasSubstr(key));
    }
  }
  json other = graph;
  for (const json& id : {json(1.5), json(1e300), json(18446744073709551615U), json("1")}) {
    other["keyframes"][0]["id"] = id;
    EXPECT_THAT(error_of(other.dump()), HasSubstr("an integer is wanted")) << id;
  }
  other = graph;
  other["format"] = 3.17e14;
  EXPECT_THAT(error_of(other.dump()), HasSubstr("an integer is wanted"));
  other["format"] = 2;
  EXPECT_THAT(error_of(other.dump()), HasSubstr("format 2"));
  other = graph;
  other["planes"][1]["id"] = graph["planes"][0]["id"];
  EXPECT_THAT(error_of(other.dump()), HasSubstr("twice"));
  other = graph;
  other["keyframes"][2]["pose"][6] = 5;
  EXPECT_THAT(error_of(other.dump()), HasSubstr("quaternion"));
  other = graph;
  other["keyframes"][2]["pose"].erase(0);
  EXPECT_THAT(error_of(other.dump()), HasSubstr("expected 7 numbers"));
  other = graph;
  other["planes"][0]["class"] = "slanted";
  EXPECT_THAT(error_of(other.dump()), HasSubstr("slanted"));
  for (const double share : {0.0, 0.3, 0.99}) {
    EXPECT_NE(error_of(text.substr(0, static_cast<std::size_t>(share * static_cast<double>(text.size())))), "");
  }
}

}  // namespace
}  // namespace sgraph
