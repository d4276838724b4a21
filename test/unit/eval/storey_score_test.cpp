#include "sgraph_slam/core/eval/storey_score.hpp"

#include <gtest/gtest.h>

namespace sgraph {
namespace {

constexpr const char* truth_text = R"({
  "storeys": [{"storey": 0, "elevation": 0.0}, {"storey": 1, "elevation": 3.0}, {"storey": 1, "elevation": 3.0}],
  "storey_of_path": [{"begin": 0.0, "end": 10.0, "storey": 0}, {"begin": 10.1, "end": 20.0, "storey": null},
                     {"begin": 20.1, "end": 30.0, "storey": 1}]})";

// A keyframe a second, half a metre above the floor; found storeys carry other numbers than the true ones.
GraphSnapshot graph(int lower, int upper) {
  GraphSnapshot map;
  for (std::int64_t k = 1; k < 30; ++k) {
    SceneKeyframe& keyframe = map.keyframes[{k}];
    keyframe.id = {k};
    keyframe.stamp = {k * 1'000'000'000};
    const double share = std::min(1.0, std::max(0.0, (static_cast<double>(k) - 10) / 10));
    keyframe.T_map_base.translation = {static_cast<double>(k), 0, 0.5 + 3 * share};
    keyframe.storey = k <= 10 ? lower : k <= 20 ? stairwell : upper;
  }
  map.storeys = {{lower, 0.01, 2.5, true}, {upper, 3.03, 5.5, true}};
  return map;
}

TEST(StoreyScore, ReadsTheTruthAndCountsRightKeyframes) {
  const auto truth = read_true_storeys(truth_text);
  ASSERT_TRUE(truth);
  EXPECT_EQ(truth->elevations.size(), 2U);
  const StoreyScore score = score_storeys(graph(1, 0), *truth, {0}, {});
  EXPECT_EQ(score.truths, 2);
  EXPECT_EQ(score.estimates, 2);
  EXPECT_EQ(score.keyframes, 18);  // those at the very change don't count
  EXPECT_EQ(score.right, 18);
  EXPECT_EQ(score.on_stairs, 9);
  EXPECT_EQ(score.stairs_misplaced, 0);
  ASSERT_EQ(score.height_errors.size(), 1U);
  EXPECT_NEAR(score.height_errors[0], 0.02, 1e-9);
}

TEST(StoreyScore, AHeightThatTheMapDoesntKnowIsNoError) {
  const auto truth = read_true_storeys(truth_text);
  GraphSnapshot map = graph(0, 1);
  map.storeys[1].height_known = false;
  const StoreyScore score = score_storeys(map, *truth, {0}, {});
  EXPECT_TRUE(score.height_errors.empty());
  EXPECT_EQ(score.heights_unknown, 1);
}

TEST(StoreyScore, CountsWhatIsWrong) {
  const auto truth = read_true_storeys(truth_text);
  GraphSnapshot map = graph(0, 0);
  map.keyframes.at({15}).storey = 0;
  map.planes[{0}].keyframes.insert({5});
  map.planes[{0}].keyframes.insert({25});
  StoreyScore score = score_storeys(map, *truth, {0}, {});
  EXPECT_EQ(score.estimates, 1);
  EXPECT_EQ(score.right, 9);
  EXPECT_EQ(score.stairs_misplaced, 1);
  EXPECT_EQ(score.planes_across, 0);  // one storey is all that this map knows
  map = graph(0, 1);
  map.planes[{0}].keyframes.insert({5});
  map.planes[{0}].keyframes.insert({25});
  EXPECT_EQ(score_storeys(map, *truth, {0}, {}).planes_across, 1);
}

TEST(StoreyScore, RefusesNumbersThatDontCountUpAndKnowsOldTruth) {
  EXPECT_THROW(read_true_storeys(R"({"storeys": [{"storey": 1, "elevation": 0}], "storey_of_path": []})"), std::runtime_error);
  EXPECT_THROW(read_true_storeys("{"), std::runtime_error);
  EXPECT_FALSE(read_true_storeys("{}"));
}

}  // namespace
}  // namespace sgraph
