#include "sgraph_slam/core/eval/place_quality.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <stdexcept>

namespace sgraph {
namespace {

FloorArea box(double x, double y, double width, double depth) { return {{{x, y}, {x + width, y}, {x + width, y + depth}, {x, y + depth}}, {}}; }

TrueDoor true_door(const char* name, double x, double y, bool wanted) { return {name, {x, y, 0}, 0.9, 2.1, wanted}; }

TEST(PlaceQuality, CommonAreaOfConcaveOutlinesAndHoles) {
  const FloorArea l{{{0, 0}, {4, 0}, {4, 2}, {2, 2}, {2, 4}, {0, 4}}, {}};
  EXPECT_NEAR(common_area(l, box(1, 1, 3, 3)), 5.0, 1e-9);
  FloorArea ring = box(0, 0, 4, 4);
  ring.holes = {box(1, 1, 2, 2).outline};
  EXPECT_NEAR(area_of(ring), 12, 1e-9);
  EXPECT_NEAR(common_area(ring, box(0, 0, 2, 4)), 6, 1e-9);
}

// Two right ones (IoU 1 and 0.8), one missed, one invented: segmentation 0.9, recognition 2 / 3.
TEST(PlaceQuality, IsTheProductOfRecognitionAndSegmentation) {
  const std::vector<TruePlace> truth{{"a", "room", box(0, 0, 4, 4), 0, 2.8, true},
                                     {"b", "room", box(5, 0, 5, 4), 0, 2.8, true},
                                     {"c", "room", box(20, 0, 4, 4), 0, 2.8, true},
                                     {"d", "room", box(30, 0, 4, 4), 0, 2.8, false}};
  std::vector<MappedPlace> found(5);
  found[0] = {1, "room", box(0, 0, 4, 4), 1.4, true, 0};
  found[1] = {1, "corridor", box(5, 0, 4, 4), 1.4, true, 0};   // rooms and corridors count on their own
  found[2] = {7, "room", box(20, 0, 1, 4), 1.4, true, 0};      // too little of c
  found[3] = {8, "room", box(30, 0, 4, 3), 1.4, true, 0};      // of a place that was not entered
  found[4] = {9, "room", box(30.5, 0.5, 2, 2), 1.4, true, 0};  // lies in it
  const PlaceQuality quality = score_places(found, truth, Pose{});
  EXPECT_EQ(quality.truths, 3);
  EXPECT_EQ(quality.estimates, 3);
  EXPECT_EQ(quality.matches.size(), 2U);
  EXPECT_EQ(quality.missed, std::vector<std::string>{"c"});
  EXPECT_EQ(quality.invented, std::vector<long long>{7});
  EXPECT_NEAR(quality.segmentation(), 0.9, 1e-9);
  EXPECT_NEAR(quality.recognition(), 2.0 / 3, 1e-9);
  EXPECT_NEAR(quality.panoptic(), 0.6, 1e-9);
  EXPECT_NEAR(quality.iou_of_truths, (1 + 0.8 + 0.25) / 3, 1e-9);
}

TEST(PlaceQuality, APlaceOnAnotherStoreyIsNone) {
  const std::vector<TruePlace> truth{{"a", "room", box(0, 0, 4, 4), 0, 2.8, true}};
  const PlaceQuality quality = score_places({{1, "room", box(0, 0, 4, 4), 4.4, true, 1}}, truth, Pose{});
  EXPECT_EQ(quality.matches.size(), 0U);
  EXPECT_EQ(quality.invented.size(), 1U);
}

TEST(DoorQuality, CountsMatchesAndErrors) {
  const std::vector<TrueDoor> truth{true_door("a", 0, 0, true), true_door("b", 5, 0, true), true_door("c", 9, 0, false)};
  const std::vector<MappedDoor> found{{1, {0.1, 0, 0}, 0.95, 2.0}, {2, {9, 0.2, 0}, 0.9, 0}, {3, {20, 0, 0}, 0.9, 0}};
  const DoorQuality quality = score_doors(found, truth, Pose{});
  EXPECT_EQ(quality.truths, 2);
  EXPECT_EQ(quality.estimates, 2);
  ASSERT_EQ(quality.position_errors.size(), 1U);
  EXPECT_NEAR(quality.position_errors[0], 0.1, 1e-9);
  EXPECT_NEAR(quality.width_errors[0], 0.05, 1e-9);
  EXPECT_NEAR(quality.height_errors.at(0), -0.1, 1e-9);
  EXPECT_EQ(quality.missed, std::vector<std::string>{"b"});
  EXPECT_EQ(quality.invented, std::vector<long long>{3});
}

TEST(MappedPlaces, ReadsOutlinesAndOldRectangles) {
  const std::string path = testing::TempDir() + "graph_places.json";
  std::ofstream(path) << R"({"rooms": [{"id": 1, "center": [2, 1, 0.4], "width": [4, 2], "yaw": 0},
    {"id": 2, "center": [9, 9, 1.4], "width": [], "polygon": [[8, 8], [10, 8], [10, 10], [8, 10]], "storey": 0}],
    "corridors": [{"id": 1, "center": [0, 5, 0.4], "width": [2], "yaw": 1.5707963267948966, "length": 10}],
    "doors": [{"id": 4, "from": 1, "to": 2, "position": [1, 2, 0], "yaw": 0, "width": 0.9, "height": 2.1}], "storeys": []})";
  const MappedPlaces places = read_mapped_places(path);
  ASSERT_EQ(places.places.size(), 3U);
  EXPECT_NEAR(area_of(places.places[0].area), 8, 1e-9);
  EXPECT_FALSE(places.places[0].z_known);
  EXPECT_NEAR(area_of(places.places[1].area), 4, 1e-9);
  EXPECT_TRUE(places.places[1].z_known);
  EXPECT_NEAR(common_area(places.places[2].area, box(-1, 0, 2, 10)), 20, 1e-6);
  ASSERT_EQ(places.doors.size(), 1U);
  EXPECT_TRUE(places.has_doors);
  EXPECT_THROW(read_mapped_places(path + ".none"), std::runtime_error);
  std::remove(path.c_str());
}

}  // namespace
}  // namespace sgraph
